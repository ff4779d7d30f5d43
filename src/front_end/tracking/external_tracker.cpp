// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/external_tracker.hpp"

#include <string>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Errors of an external odometry: this fraction of the distance and of the angle, plus these
/// constants. Chosen: its source is not known, and wheels are often off by a percent or two.
constexpr double kExternalError = 0.02;
constexpr double kExternalSigma = 0.005;       // m
constexpr double kExternalAngleSigma = 0.001;  // rad

}  // namespace

TrackedScan ExternalTracker::track(const Scan& scan, const MotionPrior& prior) {
  if (!prior.T_external_base) {
    throw InputError("front_end: no external odometry for stamp " + std::to_string(scan.stamp) +
                     " ns; give MotionPrior::T_external_base or set odometry: lidar");
  }
  TrackedScan tracked;
  if (!T_first_external_) T_first_external_ = prior.T_external_base->inverse();
  tracked.T_odom_base = *T_first_external_ * *prior.T_external_base;
  tracked.status.converged = true;
  return tracked;
}

Covariance6 ExternalTracker::covariance_of_step(const TrackedScan& from,
                                                const TrackedScan& to) const {
  const Pose T_from_to = from.T_odom_base.inverse() * to.T_odom_base;
  return diagonal_covariance(
      kExternalSigma + kExternalError * T_from_to.translation.norm(),
      kExternalAngleSigma + kExternalError * rotation_angle(T_from_to.rotation));
}

}  // namespace lidar_mapping::front_end
