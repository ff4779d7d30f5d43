// SPDX-License-Identifier: BSD-3-Clause
#include "step_checker.hpp"

#include <algorithm>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::campaign {

using front_end::TrackingState;

bool CheckedStep::is_right() const {
  return error.metres <= 3.0 * status.evidence.sigma &&
         error.degrees * kRadPerDeg <= 3.0 * status.evidence.sigma_angle;
}

std::optional<StepError> StepChecker::add(const Pose& T_map_base, const Pose& T_odom_base,
                                          TrackingState state, bool new_segment) {
  if (new_segment) last_.reset();
  std::optional<StepError> error;
  if (last_) {
    const Pose difference = (last_->T_map_base.inverse() * T_map_base).inverse() *
                            (last_->T_odom_base.inverse() * T_odom_base);
    error =
        StepError{difference.translation.norm(), rotation_angle(difference.rotation) * kDegPerRad};
    count(*error, state);
  }
  if (claims_pose(state) || new_segment) last_ = Claim{T_map_base, T_odom_base};
  return error;
}

void StepChecker::count(const StepError& error, TrackingState state) {
  counts_.wrong += error.is_wrong() ? 1 : 0;
  const bool warned = state != TrackingState::kTracking && state != TrackingState::kDegenerate;
  counts_.false_alarms += !error.is_wrong() && warned ? 1 : 0;
  if (state != TrackingState::kTracking) return;
  counts_.silent += error.is_wrong() ? 1 : 0;
  counts_.largest_error = std::max(counts_.largest_error, error.metres);
  counts_.largest_error_deg = std::max(counts_.largest_error_deg, error.degrees);
}

}  // namespace lidar_mapping::campaign
