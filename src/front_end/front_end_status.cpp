// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/front_end_status.hpp"

#include <cmath>
#include <cstdio>

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
  char degrees[32];
  std::snprintf(degrees, sizeof(degrees), "%.2f", elevation_shift * kDegPerRad);
  return std::string("the sensor's elevations were found to lack ") + degrees +
         " deg: points are turned upwards by that from here on; add it to " +
         "vertical_angle_correction_deg to have it from the start";
}

std::string full_map_message(std::size_t map_points_dropped) {
  return "the odometry's local map is full: " + std::to_string(map_points_dropped) +
         " points found no room in it so far; a larger voxel_size or a smaller local_map_radius " +
         "makes room";
}

std::string jitter_message(double jitter) {
  char milliseconds[32];
  std::snprintf(milliseconds, sizeof(milliseconds), "%.0f", 1e3 * jitter);
  return std::string("the stamps of the scans scatter by ") + milliseconds +
         " ms while the sensor turns regularly: the odometry counts turns instead; IMU, velocity "
         "and GNSS are still taken at the stamps, so have the driver stamp scans by the sensor's "
         "clock";
}

std::string ride_message() {
  return "imu: the accelerometer feels the sensor go up or down while the points show nothing of "
         "it, as in a lift: the odometry does not follow, and heights are wrong from here on "
         "unless "
         "loops or GNSS put them right";
}

std::string gyro_message() {
  return "imu: the gyro does not agree with the matched motion, so it is not used to predict; "
         "check "
         "imu_angular_unit, imu_time_offset, the axes (tf) and the range of the sensor, or set "
         "use_imu: false";
}

}  // namespace lidar_mapping::front_end
