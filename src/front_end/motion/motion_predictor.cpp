// SPDX-License-Identifier: BSD-3-Clause
#include "motion/motion_predictor.hpp"

#include <algorithm>
#include <optional>

#include <Eigen/LU>

namespace lidar_mapping::front_end {
namespace {

// Chosen: the sigma is large because measured rates refer to the stamp, and the filter's state to
// the middle of the sweep.
constexpr double kGyroSigma = 0.1;  // rad/s

}  // namespace

Eigen::Matrix3d velocity_covariance(const Matrix12d& covariance) {
  return covariance.block<3, 3>(6, 6);
}

double measured_speed_information(const PredictedMotion& predicted,
                                  const std::vector<Eigen::Vector3d>& directions) {
  const Eigen::Matrix3d measured =
      velocity_covariance(predicted.beliefs.for_unobserved.information.inverse());
  double before = 0.0;
  double after = 0.0;
  for (const Eigen::Vector3d& d : directions) {
    before += d.dot(predicted.velocity_covariance * d);
    after += d.dot(measured * d);
  }
  return std::max(0.0, 1.0 / after - 1.0 / before);
}

PredictedMotion MotionPredictor::predict(const MotionFilter& filter, const MotionPrior& prior,
                                         double seconds, double duration) {
  gyro_.add(prior, seconds, duration);
  const std::optional<MeasuredTurning> turning = gyro_.turning();
  const MotionPrior remaining = gyro_.remaining_prior(prior);
  MotionFilter nominal = filter;
  MotionFilter high_noise = filter.with_high_process_noise();
  for (MotionFilter* each : {&nominal, &high_noise}) each->predict(seconds, turning);
  const Eigen::Matrix3d before_measurement = velocity_covariance(nominal.covariance());
  for (MotionFilter* each : {&nominal, &high_noise}) apply_measurements(remaining, *each);
  const Prediction beliefs{nominal.belief(), belief_with_velocity(prior, nominal),
                           high_noise.belief()};
  return {nominal, high_noise, beliefs, filter.state().T_map_sensor.rotation, before_measurement};
}

void MotionPredictor::apply_measurements(const MotionPrior& prior, MotionFilter& filter) const {
  if (prior.angular_velocity) filter.measure_rate(*prior.angular_velocity, kGyroSigma);
  if (prior.linear_velocity) {
    filter.measure_velocity(velocity_.corrected(*prior.linear_velocity),
                            velocity_.cautious_sigma(prior.linear_velocity->norm()));
  }
}

MotionBelief MotionPredictor::belief_with_velocity(const MotionPrior& prior,
                                                   MotionFilter filter) const {
  if (prior.linear_velocity) {
    filter.measure_velocity(velocity_.corrected(*prior.linear_velocity), velocity_.usual_sigma());
  }
  return filter.belief();
}

void MotionPredictor::learn_rotation(const PredictedMotion& predicted, const MotionFilter& filter,
                                     const MotionState& matched) {
  gyro_.update(predicted.previous_rotation, filter.forecast_state().T_map_sensor.rotation,
               matched.T_map_sensor.rotation);
}

void MotionPredictor::learn_contradiction(const SweepSmoother& smoother, const MotionFilter& filter,
                                          double duration) {
  const std::optional<Eigen::Vector3d> rate = gyro_.rate();
  if (!rate) return;
  const std::optional<double> contradiction = smoother.contradiction_to(*rate, filter, duration);
  if (contradiction) gyro_.add_contradiction(*contradiction);
}

void MotionPredictor::learn_velocity(const MotionPrior& prior, const MotionState& matched) {
  if (prior.linear_velocity) velocity_.update(*prior.linear_velocity, matched.twist.head<3>());
}

}  // namespace lidar_mapping::front_end
