// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/front_end/motion_prior.hpp"

#include "matching/sweep_matcher.hpp"
#include "motion/gyro_validator.hpp"
#include "motion/motion_filter.hpp"
#include "motion/sweep_smoother.hpp"
#include "motion/velocity_validator.hpp"

namespace lidar_mapping::front_end {

/// The motion filter predicted to a scan, before the scan is matched.
struct PredictedMotion {
  MotionFilter filter;
  MotionFilter high_noise_filter;  ///< with the largest accelerations
  Prediction beliefs;              ///< those of the filters
  /// Rotation at the previous scan.
  Eigen::Quaterniond previous_rotation;
  /// Covariance of the velocity, m^2/s^2, before measured velocities were applied.
  Eigen::Matrix3d velocity_covariance;
};

/// Covariance of the linear velocity, m^2/s^2, in that of pose and twist.
Eigen::Matrix3d velocity_covariance(const Matrix12d& covariance);

/// Information (s^2/m^2) of other sensors about the speed along these directions (unit vectors).
double measured_speed_information(const PredictedMotion& predicted,
                                  const std::vector<Eigen::Vector3d>& directions);

/// Predicts the motion to the next scan from the motion so far and from the measurements of other
/// sensors, whose errors are learned from the matches.
class MotionPredictor {
 public:
  /// Predicts to a sweep of `duration` seconds, `seconds` after the state of the filter.
  PredictedMotion predict(const MotionFilter& filter, const MotionPrior& prior, double seconds,
                          double duration);
  /// Learns from a matched rotation. `filter` is the one from which the match started.
  void learn_rotation(const PredictedMotion& predicted, const MotionFilter& filter,
                      const MotionState& matched);
  /// Learns from the time slices of the last sweep, which lasted `duration` seconds.
  void learn_contradiction(const SweepSmoother& smoother, const MotionFilter& filter,
                           double duration);
  /// Learns from a matched velocity that the points observed in all directions.
  void learn_velocity(const MotionPrior& prior, const MotionState& matched);

  bool accepts_gyro(const MotionPrior& prior) const { return gyro_.accepts(prior); }
  bool is_gyro_distrusted() const { return gyro_.is_distrusted(); }
  bool is_velocity_distrusted() const { return velocity_.is_distrusted(); }

 private:
  /// Applies angular rate and velocity; the velocity is weighted as one that may have become wrong
  /// just now.
  void apply_measurements(const MotionPrior& prior, MotionFilter& filter) const;
  /// The filter's belief after applying the measured velocity with its usual accuracy.
  MotionBelief belief_with_velocity(const MotionPrior& prior, MotionFilter filter) const;

  GyroValidator gyro_;
  VelocityValidator velocity_;
};

}  // namespace lidar_mapping::front_end
