#include "ray_returns.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace lidar_mapping::simulation {

namespace {

std::size_t column_of(const Point& point, const LidarModel& lidar) {
  const double turn = (M_PI - std::atan2(point.y, point.x)) / (2.0 * M_PI);
  return static_cast<std::size_t>(std::lround(turn * lidar.columns)) %
         static_cast<std::size_t>(lidar.columns);
}

std::size_t beam_of(const Point& point, const LidarModel& lidar) {
  const std::vector<double>& elevations = lidar.elevations;
  const double elevation = std::atan2(point.z, std::hypot(point.x, point.y));
  const auto below =
      std::lower_bound(elevations.begin(), elevations.end(), elevation, std::greater<>());
  if (below == elevations.begin()) return 0;
  const auto above = below - 1;
  const bool is_lower = below != elevations.end() && elevation - *below < *above - elevation;
  return static_cast<std::size_t>((is_lower ? below : above) - elevations.begin());
}

}  // namespace

Stamp column_delay(const LidarModel& lidar, Stamp period, int column) {
  return period * column / lidar.columns;
}

std::vector<Eigen::Vector3d> ray_directions(const LidarModel& lidar) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(static_cast<std::size_t>(lidar.columns) * lidar.elevations.size());
  for (int column = 0; column < lidar.columns; ++column) {
    const double azimuth = column_azimuth(lidar, column);
    for (const double elevation : lidar.elevations) {
      directions.emplace_back(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    }
  }
  return directions;
}

std::vector<RayReturn> returns_of(const SimulatedScan& scan, const LidarModel& lidar) {
  const std::size_t beams = lidar.elevations.size();
  std::vector<RayReturn> returns(static_cast<std::size_t>(lidar.columns) * beams);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Point& point = scan.cloud.points[i];
    returns[column_of(point, lidar) * beams + beam_of(point, lidar)] = {true, point,
                                                                        scan.moving[i]};
  }
  return returns;
}

SimulatedScan scan_of(const std::vector<RayReturn>& returns, const SimulatedScan& scan,
                      const LidarModel& lidar) {
  const std::size_t beams = lidar.elevations.size();
  SimulatedScan result;
  result.stamp = scan.stamp;
  result.end = scan.end;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    if (!returns[i].there) continue;
    result.cloud.points.push_back(returns[i].point);
    result.moving.push_back(returns[i].moving);
    if (!scan.cloud.has_times()) continue;
    const Stamp delay = column_delay(lidar, scan.end - scan.stamp, static_cast<int>(i / beams));
    result.cloud.times.push_back(static_cast<float>(to_seconds(delay)));
  }
  return result;
}

}  // namespace lidar_mapping::simulation
