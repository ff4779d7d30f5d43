// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/front_end_status.hpp"

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {

const char* to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kDegenerate:
      return "degenerate";
    case TrackingState::kDoubtful:
      return "doubtful";
    case TrackingState::kDegraded:
      return "degraded";
    case TrackingState::kLost:
      return "lost";
  }
  return "";
}

bool claims_pose(TrackingState state) {
  return state != TrackingState::kDegraded && state != TrackingState::kLost;
}

std::string elevation_message(double elevation_shift) {
  return formatted(
      "the elevation angles of the sensor are too low by %.2f deg, so points are rotated upwards "
      "by this angle from now on; add it to vertical_angle_correction_deg to correct the whole "
      "drive",
      elevation_shift * kDegPerRad);
}

}  // namespace lidar_mapping::front_end
