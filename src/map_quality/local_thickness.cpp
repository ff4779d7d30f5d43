// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "cell_statistics.hpp"

namespace lidar_mapping::map_quality {

namespace {

constexpr double kCell = 0.5;           // m
constexpr double kMinExtent = 0.15;     // of the cell
constexpr double kMaxFlatness = 0.2;    // thickness of the plane's own group against its extent
constexpr double kGate = 0.3;           // m; groups farther from the plane are something else
constexpr double kMinPlanePoints = 15;  // of the group that gives the plane
constexpr double kMinGroupPoints = 5;

/// The points of one group in a cell, and the directions from which they were seen.
struct Group {
  int number = 0;
  PointMoments points;
  Eigen::Matrix3d beams = Eigen::Matrix3d::Zero();
};
using Cells = std::unordered_map<VoxelKey, std::vector<Group>>;

Group& group_in(std::vector<Group>& groups, int number) {
  if (groups.empty() || groups.back().number != number) {
    groups.emplace_back();
    groups.back().number = number;
  }
  return groups.back();
}

Cells gather(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config) {
  Cells cells;
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    const PointCloudPtr cloud = clouds.cloud(poses.poses[i].index);
    if (!cloud) continue;
    const Pose& T_map_base = poses.poses[i].T_map_base;
    const Eigen::Vector3d sensor =
        T_map_base * config.p_base_sensor.value_or(Eigen::Vector3d::Zero());
    for (const Point& point : cloud->points) {
      const Eigen::Vector3d p = T_map_base * point.position().cast<double>();
      const Eigen::Vector3d beam = p - sensor;
      if (!(beam.squaredNorm() < config.reach * config.reach)) continue;
      const int number = static_cast<int>(i) / config.group;
      const VoxelKey key = cell_key(p, kCell);
      Group& group = group_in(cells[key], number);
      group.points.add(p);
      group.beams += beam * beam.transpose() / beam.squaredNorm();
    }
  }
  return cells;
}

struct Sample {
  double thickness;
  double ratio;
  double within;
};

/// All groups near the plane count alike: variance within them and between their means.
Sample measured(const std::vector<Group>& groups, const Plane& plane, double range_noise) {
  double groups_used = 0.0;
  double within = 0.0;
  double mean = 0.0;
  double square = 0.0;
  double expected = 0.0;
  for (const Group& group : groups) {
    if (group.points.count < kMinGroupPoints) continue;
    const double distance = plane.normal.dot(group.points.mean() - plane.centre);
    if (std::abs(distance) > kGate) continue;
    groups_used += 1.0;
    within += plane.normal.dot(group.points.covariance() * plane.normal);
    mean += distance;
    square += distance * distance;
    expected += plane.normal.dot(group.beams * plane.normal) / group.points.count;
  }
  mean /= groups_used;
  const double between = std::max(0.0, square / groups_used - mean * mean);
  within = std::max(0.0, within / groups_used);
  const double total = std::sqrt(within + between);
  return {total, total / (range_noise * std::sqrt(expected / groups_used)), std::sqrt(within)};
}

Thickness summary(const std::vector<Sample>& samples) {
  std::vector<double> thicknesses;
  std::vector<double> ratios;
  std::vector<double> withins;
  for (const Sample& sample : samples) {
    thicknesses.push_back(sample.thickness);
    ratios.push_back(sample.ratio);
    withins.push_back(sample.within);
  }
  return {samples.size(), quantile(thicknesses, 0.5), quantile(thicknesses, 0.9),
          quantile(ratios, 0.5), quantile(withins, 0.5)};
}

}  // namespace

LocalThickness local_thickness(const KeyFramePoses& poses, CloudSource& clouds,
                               const QualityConfig& config) {
  std::vector<Sample> ground;
  std::vector<Sample> walls;
  double with_extent = 0.0;
  double planar = 0.0;
  for (const auto& [key, groups] : gather(poses, clouds, config)) {
    const auto largest = std::max_element(
        groups.begin(), groups.end(),
        [](const Group& a, const Group& b) { return a.points.count < b.points.count; });
    if (largest->points.count < kMinPlanePoints) continue;
    const Plane plane = plane_of(largest->points);
    if (plane.extent < kMinExtent * kCell) continue;
    with_extent += 1.0;
    if (plane.thickness > kMaxFlatness * plane.extent) continue;
    planar += 1.0;
    if (is_ground(plane)) ground.push_back(measured(groups, plane, config.range_noise));
    if (is_wall(plane)) walls.push_back(measured(groups, plane, config.range_noise));
  }
  return {summary(ground), summary(walls), with_extent > 0.0 ? planar / with_extent : 0.0};
}

}  // namespace lidar_mapping::map_quality
