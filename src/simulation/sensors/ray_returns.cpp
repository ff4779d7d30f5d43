// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/ray_returns.hpp"

namespace lidar_mapping::simulation {

std::vector<RayReturn> returns_of(const SimulatedScan& scan, const LidarModel& lidar) {
  std::vector<RayReturn> returns(lidar.ray_count());
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    returns[scan.rays[i]] = {true, scan.cloud.points[i], scan.moving[i]};
  }
  return returns;
}

SimulatedScan scan_of(const std::vector<RayReturn>& returns, const SimulatedScan& scan,
                      const LidarModel& lidar) {
  const auto beams = static_cast<std::size_t>(lidar.beams);
  SimulatedScan result;
  result.stamp = scan.stamp;
  result.end = scan.end;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    if (!returns[i].is_valid) continue;
    result.cloud.points.push_back(returns[i].point);
    result.moving.push_back(returns[i].moving);
    result.rays.push_back(static_cast<std::uint32_t>(i));
    if (!scan.cloud.has_times()) continue;
    const Stamp delay = column_delay(lidar, scan.end - scan.stamp, static_cast<int>(i / beams));
    result.cloud.times.push_back(static_cast<float>(to_seconds(delay)));
  }
  return result;
}

}  // namespace lidar_mapping::simulation
