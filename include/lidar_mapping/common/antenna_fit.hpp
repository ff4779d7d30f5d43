// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// A good fix beside the vehicle's motion by dead reckoning or odometry; both level, so two axes
/// are enough. `dr` is the frame of dead reckoning, which turns and drifts against East-North-Up.
struct TrackedFix {
  Stamp stamp = 0;  ///< of the fix, from which `applied_delay` is taken off
  /// Of the antenna by the fix: East and North, m.
  Eigen::Vector2d p_enu = Eigen::Vector2d::Zero();
  double yaw_dr = 0.0;                                       ///< heading of base_link in dr, rad
  Eigen::Vector2d p_dr_base = Eigen::Vector2d::Zero();       ///< of base_link, m
  Eigen::Vector2d v_dr = Eigen::Vector2d::Zero();            ///< of the antenna, axes of dr, m/s
  Eigen::Vector2d p_base_antenna = Eigen::Vector2d::Zero();  ///< as tf has it, m
  double applied_delay = 0.0;  ///< s that were taken off the stamp already
};

/// Estimates how late a receiver's stamps are and where its antenna is, from windows in which fixes
/// are aligned with dead reckoning. In a window of 12 s, with heading, origin and gyro bias of its
/// own,
///   R(yaw)^T p_enu - s = p_dr + R_dr (l + dl) - v_dr d + b q,   q = sum of t J dp_dr,
/// is linear in all unknowns. The unknowns of each window are eliminated, and the rest is added to
/// the normal equations of d (late by, s) and dl (antenna beside tf's, m).
class AntennaFit {
 public:
  /// Adds the next fix, in the order of the stamps; one that lies more than 12 s behind the first
  /// of the window begins a new window.
  void add(const TrackedFix& fix);
  /// Begins a window, because dead reckoning does not connect the next fix to those before. The one
  /// that was open counts in result() from now on.
  void begin_window();
  /// Removes all windows.
  void clear() { *this = {}; }

  /// The fit of all windows that are complete.
  struct Result {
    double delay = 0.0;        ///< s by which the stamps are late
    double delay_sigma = 0.0;  ///< standard deviation of `delay`, s
    /// What tf's lever arm lacks, m, in base_link.
    Eigen::Vector2d arm_error = Eigen::Vector2d::Zero();
    double arm_sigma = 0.0;  ///< standard deviation of the worse component of `arm_error`, m

    /// The delay is known to 8 ms, which is well enough to correct it.
    bool delay_is_known() const;
    /// The stamps are late, or early, by more than 10 ms and four standard deviations.
    bool is_late() const;
  };
  /// Standard deviation of a lever arm, m. Chosen as of one that was measured with a ruler.
  static constexpr double kMeasuredArm = 0.03;
  /// The fit so far. `arm_prior`: standard deviation (m) of tf's lever arm as far as it is known
  /// beforehand.
  Result result(double arm_prior = kMeasuredArm) const;

 private:
  std::vector<TrackedFix> window_;
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();  ///< arm x, arm y, delay
  Eigen::Vector3d right_side_ = Eigen::Vector3d::Zero();
};

}  // namespace lidar_mapping
