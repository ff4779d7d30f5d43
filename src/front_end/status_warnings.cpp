// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/status_warnings.hpp"

namespace lidar_mapping::front_end {

std::vector<StatusWarning> warnings_of(const FrontEndStatus& status) {
  std::vector<StatusWarning> warnings;
  if (status.map_points_dropped > 0) {
    warnings.push_back({kFullMapKey, full_map_message(status.map_points_dropped)});
  }
  if (status.stamp_jitter > 0.0) {
    warnings.push_back({"jitter", jitter_message(status.stamp_jitter)});
  }
  if (status.sweep_times.source != SweepTimes::kAsGiven) {
    warnings.push_back({"sweep times", sweep_times_message(status.sweep_times)});
  }
  if (status.gyro_distrusted) warnings.push_back({"gyro", gyro_message()});
  if (status.unseen_way > 0.0) warnings.push_back({"ride", ride_message()});
  return warnings;
}

}  // namespace lidar_mapping::front_end
