// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "matching/sweep_matcher.hpp"
#include "motion/deviation_filter.hpp"
#include "motion/motion_filter.hpp"

namespace lidar_mapping::front_end {

/// Pose and twist at a moment of a sweep, the change of the twist per second, and the covariance of
/// the pose as far as it comes from the motion within the sweep.
struct MotionAtStamp {
  MotionState state;
  Vector6d acceleration = Vector6d::Zero();
  Covariance6 covariance = Covariance6::Zero();
};

/// Pose and twist at the end of a sweep, with their covariance in the axes there.
struct SweepEnd {
  MotionState state;
  Matrix12d covariance = Matrix12d::Zero();
};

/// The covariance of a match (pose and twist) without that of the twist, as far as the smoother
/// replaces the motion within the sweep: not a measured rotation.
Matrix12d without_smoothed_twist(const Matrix12d& of_match, bool rotation_measured);

/// Finds how the sensor moved during a sweep. The match takes the twist as constant. Here the pose
/// may deviate from that motion: a Kalman smoother over the time slices of the sweep estimates the
/// deviation, with white noise as its acceleration (Barfoot, Tong, Särkkä 2014). It begins where
/// the smoother of the previous sweep ended, so both sweeps determine the pose between them. The
/// size of the noise is learned from the drive.
class SweepSmoother {
 public:
  /// Forgets the previous sweep and the size of the noise.
  void reset();
  /// To be called after `filter` was corrected with the match of a sweep of `duration` seconds.
  void add(const SweepMatcher::Found& found, const MotionFilter& filter, double duration);
  /// The motion `seconds` after the middle of the last sweep: the smoothed one if that sweep was
  /// smoothed, else that of the filter.
  MotionAtStamp motion_at(double seconds, const MotionFilter& filter, double duration) const;
  /// How far a gyro's mean rate during the last sweep (rad/s) is from what the time slices say, as
  /// a squared difference divided by its covariance: about 1 or less for a gyro that is right.
  /// Empty if nothing can be said.
  std::optional<double> contradiction_to(const Eigen::Vector3d& rate, const MotionFilter& filter,
                                         double duration) const;
  /// Whether the sweep was smoothed that `filter` was corrected with last, after which nothing was
  /// predicted.
  bool is_smoothed(const MotionFilter& filter) const;
  /// Whether the last sweep that was matched was smoothed.
  bool has_smoothed_last_match() const { return deviations_.has_value(); }
  /// The covariance that motion_at() gave the last time that a sweep was smoothed, for the begin.
  const Covariance6& usual_covariance() const { return usual_covariance_; }

 private:
  void learn_noise(const MotionFilter& filter, double duration);
  void learn_scale(const SweepDeviations& before, const SweepDeviations& after);
  Covariance6 scaled(const Covariance6& covariance) const;
  double newest_weight() const;
  void smooth(const SweepMatcher::Found& found, const MotionFilter& filter, double duration);

  std::optional<SweepEnd> end_;                ///< of the last sweep
  std::optional<SweepDeviations> deviations_;  ///< of the last sweep, if it was smoothed
  int learned_sweeps_ = 0;
  /// Power spectral density of the acceleration: linear (m^2/s^3), angular (rad^2/s^3).
  Eigen::Vector2d noise_ = Eigen::Vector2d::Zero();
  // How far sweeps move the deviation at their begin, and how far they should; m^2, rad^2.
  Eigen::Vector2d squared_innovation_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d expected_innovation_ = Eigen::Vector2d::Zero();
  std::optional<double> contradiction_;  ///< of the last sweep to its measured rotation
  Covariance6 usual_covariance_ = Covariance6::Zero();
};

}  // namespace lidar_mapping::front_end
