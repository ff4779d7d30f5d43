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

std::string full_map_message(std::size_t map_points_dropped) {
  return "the odometry's local map is full: " + std::to_string(map_points_dropped) +
         " points found no room in it so far; a larger voxel_size or a smaller local_map_radius " +
         "makes room";
}

std::string jitter_message(double jitter) {
  return formatted(
      "the stamps of the scans scatter by %.0f ms while the sensor turns regularly: the odometry "
      "counts turns instead; IMU, velocity and GNSS are still taken at the stamps, so have the "
      "driver stamp scans by the sensor's clock",
      1e3 * jitter);
}

std::string ride_message() {
  return "imu: the accelerometer feels the sensor go up or down while the points show nothing of "
         "it, as in a lift: the odometry does not follow, and heights are wrong from here on "
         "unless loops or GNSS put them right";
}

std::string gyro_message() {
  return "imu: the gyro does not agree with the matched motion, so it is not used to predict; "
         "check imu_angular_unit, imu_time_offset, the axes (tf) and the range of the sensor, or "
         "set use_imu: false";
}

}  // namespace lidar_mapping::front_end
