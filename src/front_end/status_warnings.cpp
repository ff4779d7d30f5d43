// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/status_warnings.hpp"

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::front_end {

std::vector<StatusWarning> warnings_of(const FrontEndStatus& status) {
  std::vector<StatusWarning> warnings;
  const auto warn = [&](const char* key, const std::string& text) {
    warnings.push_back({key, text});
  };
  if (status.map_points_dropped > 0) {
    warn(kFullMapKey,
         "the odometry's local map is full: " + std::to_string(status.map_points_dropped) +
             " points could not be inserted so far; choose a larger voxel_size or a "
             "smaller local_map_radius");
  }
  if (status.stamp_jitter > 0.0) {
    warn("jitter",
         formatted("the stamps of the scans scatter by %.0f ms while the sensor turns regularly: "
                   "the odometry counts turns instead, but IMU, velocity and GNSS are still taken "
                   "at the stamps; let the driver stamp scans by the sensor's clock",
                   1e3 * status.stamp_jitter));
  }
  if (status.sweep_times.source != SweepTimes::kAsGiven)
    warn("sweep times", sweep_times_message(status.sweep_times));
  if (status.gyro_distrusted) {
    warn("gyro",
         "imu: the gyro does not agree with the matched motion, so it is not used to predict; "
         "check imu_angular_unit, imu_time_offset, the axes (tf) and the range of the sensor, or "
         "set use_imu: false");
  }
  if (status.velocity_distrusted) {
    warn("velocity",
         "velocity: it does not agree with the matched motion; check its unit (m/s), its sign, its "
         "axes (tf) and whether its sensor measures, or set use_velocity: false");
  }
  if (status.vertical_ride_distance > 0.0) {
    warn("ride",
         "imu: the accelerometer measures a vertical motion that the points do not show, as in a "
         "lift: the odometry does not follow it, and heights are wrong from now on unless loops or "
         "GNSS correct them");
  }
  return warnings;
}

}  // namespace lidar_mapping::front_end
