// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/step_origin.hpp"

#include <cmath>

namespace lidar_mapping::front_end {
namespace {

// Two scans that see the same part of the map have the same error. When new parts, which were
// inserted at the previous poses, come into view, the errors become different and then accumulate:
// measured on simulated drives.
constexpr double kSharedMapFactor = 0.3;  // of the variance of two independent poses
constexpr double kNewMapDistance = 1.5;   // m
constexpr double kNewMapAngle = 0.02;     // rad

}  // namespace

Covariance6 step_covariance(const PoseEstimate& from, const PoseEstimate& to) {
  const Pose T_from_to = from.T_odom_base.inverse() * to.T_odom_base;
  const double drift = T_from_to.translation.norm() / kNewMapDistance +
                       rotation_angle(T_from_to.rotation) / kNewMapAngle;
  return compose_covariance(
             (kSharedMapFactor + from.drift_variance_factor * drift) * from.covariance, T_from_to,
             (kSharedMapFactor + to.drift_variance_factor * drift) * to.covariance) +
         compose_covariance(from.sweep_covariance, T_from_to, to.sweep_covariance);
}

void StepOrigin::set_step_to(const PoseEstimate& estimate, StepEvidence& evidence) const {
  const Covariance6 covariance = step_covariance(estimate_, estimate);
  evidence.seconds = elapsed_;
  evidence.sigma = std::sqrt(covariance.topLeftCorner<3, 3>().trace());
  evidence.sigma_angle = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
}

void StepOrigin::update(const TrackedScan& tracked) {
  if (!claims_pose(tracked.status.state) && !tracked.new_segment) return;
  estimate_ = static_cast<const PoseEstimate&>(tracked);
  elapsed_ = 0.0;
}

}  // namespace lidar_mapping::front_end
