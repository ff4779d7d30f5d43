// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/status_warnings.hpp"

#include <array>
#include <utility>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::front_end {

namespace {

// Each of these is the text of a warning, empty without its cause.

std::string full_map_warning(const FrontEndStatus& status) {
  if (status.map_points_dropped == 0) return {};
  return "the odometry's local map is full: " + std::to_string(status.map_points_dropped) +
         " points could not be inserted so far; choose a larger voxel_size or a smaller "
         "local_map_radius";
}

std::string jitter_warning(const FrontEndStatus& status) {
  if (!(status.stamp_jitter > 0.0)) return {};
  return formatted(
      "the stamps of the scans scatter by %.0f ms while the sensor turns regularly: the odometry "
      "counts turns instead, but IMU, velocity and GNSS are still taken at the stamps; let the "
      "driver stamp scans by the sensor's clock",
      1e3 * status.stamp_jitter);
}

std::string sweep_times_warning(const FrontEndStatus& status) {
  if (status.sweep_times.source == SweepTimes::kAsGiven) return {};
  return sweep_times_message(status.sweep_times);
}

std::string gyro_warning(const FrontEndStatus& status) {
  if (!status.gyro_distrusted) return {};
  return "imu: the gyro does not agree with the matched motion, so it is not used to predict; "
         "check imu_angular_unit, imu_time_offset, the axes (tf) and the range of the sensor, or "
         "set use_imu: false";
}

std::string velocity_warning(const FrontEndStatus& status) {
  if (!status.velocity_distrusted) return {};
  return "velocity: it does not agree with the matched motion; check its unit (m/s), its sign, its "
         "axes (tf) and whether its sensor measures, or set use_velocity: false";
}

std::string ride_warning(const FrontEndStatus& status) {
  if (!(status.vertical_ride_distance > 0.0)) return {};
  return "imu: the accelerometer measures a vertical motion that the points do not show, as in a "
         "lift: the odometry does not follow it, and heights are wrong from now on unless loops or "
         "GNSS correct them";
}

struct WarningKind {
  const char* key;
  std::string (*text)(const FrontEndStatus& status);
};
constexpr std::array<WarningKind, 6> kWarningKinds = {{{kFullMapKey, full_map_warning},
                                                       {"jitter", jitter_warning},
                                                       {"sweep times", sweep_times_warning},
                                                       {"gyro", gyro_warning},
                                                       {"velocity", velocity_warning},
                                                       {"ride", ride_warning}}};

}  // namespace

std::vector<StatusWarning> warnings_of(const FrontEndStatus& status) {
  std::vector<StatusWarning> warnings;
  for (const WarningKind& kind : kWarningKinds) {
    std::string text = kind.text(status);
    if (!text.empty()) warnings.push_back({kind.key, std::move(text)});
  }
  return warnings;
}

}  // namespace lidar_mapping::front_end
