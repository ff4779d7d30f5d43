// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "cell_statistics.hpp"

namespace lidar_mapping::map_quality {

namespace {

// m, edge of a cell. Chosen: larger ones hold more than one surface or a curved one, smaller ones
// too few points.
constexpr double kCell = 0.5;
// Ratio of thickness to extent of the group that gives the plane. Chosen: vegetation is thicker,
// and a wall with the range noise of a LiDAR (0.02 m) is thinner even if it covers half a cell.
constexpr double kMaxFlatness = 0.2;
// m; groups farther from the plane belong to another surface. Chosen a little above half a cell,
// because such a group is in the cell with a part of its points only.
constexpr double kMaxPlaneDistance = 0.3;
// Points of the group that gives the plane: five for each of its three unknowns; chosen.
constexpr double kMinPlanePoints = 15;
// Points of a group that is measured against the plane. Chosen: fewer than for a plane, since only
// its mean and a variance are needed.
constexpr double kMinGroupPoints = 5;

/// Points of one group in a cell, and the sum of the outer products of their ray directions.
struct Group {
  int number = 0;
  /// Relative to the corner of the cell: far from the origin of the map, the squares of its
  /// coordinates would leave nothing of a variance of millimetres.
  PointMoments points;
  Eigen::Matrix3d beams = Eigen::Matrix3d::Zero();
};
using Cells = std::unordered_map<VoxelKey, std::vector<Group>, VoxelKeyHash>;

Group& group_in(std::vector<Group>& groups, int number) {
  if (groups.empty() || groups.back().number != number) {
    groups.emplace_back();
    groups.back().number = number;
  }
  return groups.back();
}

Cells group_points_by_cell(const KeyFramePoses& poses, CloudSource& clouds,
                           const QualityConfig& config) {
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
      if (!(beam.squaredNorm() < config.max_range * config.max_range)) continue;
      const int number = static_cast<int>(i) / config.group_size;
      const VoxelIndex cell = voxel_index(p / kCell);
      Group& group = group_in(cells[voxel_key(cell)], number);
      group.points.add(p - kCell * cell.cast<double>());
      group.beams += beam * beam.transpose() / beam.squaredNorm();
    }
  }
  return cells;
}

struct CellThickness {
  double thickness;
  double ratio;
  double within_groups;
};

/// Thickness of a cell: variance within the groups plus variance of their means. All groups near
/// the plane have the same weight.
CellThickness cell_thickness(const std::vector<Group>& groups, const Plane& plane,
                             double range_noise) {
  double groups_used = 0.0;
  double within_groups = 0.0;
  double mean = 0.0;
  double square = 0.0;
  double expected = 0.0;
  for (const Group& group : groups) {
    if (group.points.count < kMinGroupPoints) continue;
    const double distance = plane.normal.dot(group.points.mean() - plane.centre);
    if (std::abs(distance) > kMaxPlaneDistance) continue;
    groups_used += 1.0;
    within_groups += plane.normal.dot(group.points.covariance() * plane.normal);
    mean += distance;
    square += distance * distance;
    expected += plane.normal.dot(group.beams * plane.normal) / group.points.count;
  }
  mean /= groups_used;
  const double between_groups = std::max(0.0, square / groups_used - mean * mean);
  within_groups = std::max(0.0, within_groups / groups_used);
  const double total = std::sqrt(within_groups + between_groups);
  return {total, total / (range_noise * std::sqrt(expected / groups_used)),
          std::sqrt(within_groups)};
}

Thickness summarize(const std::vector<CellThickness>& samples) {
  const auto quantile_of = [&](double CellThickness::*figure, double fraction) {
    std::vector<double> values;
    for (const CellThickness& sample : samples) values.push_back(sample.*figure);
    return quantile(std::move(values), fraction);
  };
  return {samples.size(), quantile_of(&CellThickness::thickness, 0.5),
          quantile_of(&CellThickness::thickness, 0.9), quantile_of(&CellThickness::ratio, 0.5),
          quantile_of(&CellThickness::within_groups, 0.5)};
}

}  // namespace

LocalThickness local_thickness(const KeyFramePoses& poses, CloudSource& clouds,
                               const QualityConfig& config) {
  std::vector<CellThickness> ground;
  std::vector<CellThickness> walls;
  double with_extent = 0.0;
  double planar = 0.0;
  for (const auto& [key, groups] : group_points_by_cell(poses, clouds, config)) {
    const auto largest = std::max_element(
        groups.begin(), groups.end(),
        [](const Group& a, const Group& b) { return a.points.count < b.points.count; });
    if (largest->points.count < kMinPlanePoints) continue;
    const Plane plane = plane_of(largest->points);
    if (plane.extent < kMinExtent * kCell) continue;
    with_extent += 1.0;
    if (plane.thickness > kMaxFlatness * plane.extent) continue;
    planar += 1.0;
    if (is_ground(plane)) ground.push_back(cell_thickness(groups, plane, config.range_noise));
    if (is_wall(plane)) walls.push_back(cell_thickness(groups, plane, config.range_noise));
  }
  return {summarize(ground), summarize(walls), with_extent > 0.0 ? planar / with_extent : 0.0};
}

}  // namespace lidar_mapping::map_quality
