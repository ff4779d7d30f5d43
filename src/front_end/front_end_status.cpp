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
      "the sensor's elevations were found to lack %.2f deg: points are turned upwards by that from "
      "here on; add it to vertical_angle_correction_deg to have it from the start",
      elevation_shift * kDegPerRad);
}

}  // namespace lidar_mapping::front_end
