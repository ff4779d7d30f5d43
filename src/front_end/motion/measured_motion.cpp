// SPDX-License-Identifier: BSD-3-Clause
#include "motion/measured_motion.hpp"

namespace lidar_mapping::front_end {
namespace {

// Chosen: the sigma is large because measured rates refer to the stamp, and the filter's state to
// the middle of the sweep.
constexpr double kGyroSigma = 0.1;  // rad/s

}  // namespace

void MeasuredMotion::apply(const MotionPrior& prior, MotionFilter& filter) const {
  if (prior.angular_velocity) filter.measure_rate(*prior.angular_velocity, kGyroSigma);
  if (prior.linear_velocity) {
    filter.measure_velocity(validator_.corrected(*prior.linear_velocity),
                            validator_.cautious_sigma(prior.linear_velocity->norm()));
  }
}

registration::MotionBelief MeasuredMotion::belief_with_velocity(const MotionPrior& prior,
                                                                MotionFilter filter) const {
  if (prior.linear_velocity) {
    filter.measure_velocity(validator_.corrected(*prior.linear_velocity), validator_.usual_sigma());
  }
  return filter.belief();
}

void MeasuredMotion::update(const MotionPrior& prior, const Eigen::Vector3d& true_velocity) {
  if (prior.linear_velocity) validator_.update(*prior.linear_velocity, true_velocity);
}

}  // namespace lidar_mapping::front_end
