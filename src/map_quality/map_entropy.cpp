// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <Eigen/LU>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "cell_statistics.hpp"

namespace lidar_mapping::map_quality {

namespace {

// m, radius of the neighbourhood: the one of Razlaw et al. 2015.
constexpr double kRadius = 0.3;
// m, radius around a key frame in which the entropy is computed. Chosen: near the path the points
// are dense enough for kMinNeighbours with any sensor.
constexpr double kLocationRadius = 8.0;
// m, key frames within this distance provide the points: the default of QualityConfig::max_range.
constexpr double kKeyFrameRadius = 30.0;
// Locations along the whole path, and points per location. Chosen: they bound the time, while the
// mean is one of up to 90,000 neighbourhoods.
constexpr std::size_t kLocations = 60;
constexpr std::size_t kPointsPerLocation = 1500;
// A covariance of three dimensions needs four points; one more is chosen against chance.
constexpr double kMinNeighbours = 5.0;

struct EntropySum {
  double entropy = 0.0;
  double points = 0.0;
  double neighbours = 0.0;
};

using Cells = std::unordered_map<VoxelKey, std::vector<Eigen::Vector3d>, VoxelKeyHash>;

/// Points of all key frames around a location, relative to its key frame.
std::vector<Eigen::Vector3d> points_around(const std::vector<KeyFramePose>& poses,
                                           std::size_t location, CloudSource& clouds) {
  std::vector<Eigen::Vector3d> points;
  const Eigen::Vector3d centre = poses[location].T_map_base.translation;
  const double max_range = kLocationRadius + kRadius;
  for (const KeyFramePose& pose : poses) {
    if ((pose.T_map_base.translation - centre).norm() > kKeyFrameRadius) continue;
    const PointCloudPtr cloud = clouds.cloud(pose.index);
    if (!cloud) continue;
    const Pose T_centre_base{pose.T_map_base.rotation, pose.T_map_base.translation - centre};
    for (const Point& point : cloud->points) {
      const Eigen::Vector3d p = T_centre_base * point.position().cast<double>();
      if (p.squaredNorm() < max_range * max_range) points.push_back(p);
    }
  }
  return points;
}

PointMoments neighbours_of(const Eigen::Vector3d& point, const Cells& cells) {
  PointMoments moments;
  // Not by for_voxels_around(), whose order is another: x is the fastest here, and the sums and
  // with them the digits of stored results depend on that.
  for (int n = 0; n < 27; ++n) {
    const Eigen::Vector3d step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    const auto cell = cells.find(cell_key(point + kRadius * step, kRadius));
    if (cell == cells.end()) continue;
    for (const Eigen::Vector3d& other : cell->second) {
      const Eigen::Vector3d offset = other - point;
      if (offset.squaredNorm() < kRadius * kRadius) moments.add(offset);
    }
  }
  return moments;
}

/// Sum of half the logarithms of det(2 pi e covariance) at evenly selected points.
EntropySum entropy_of(const std::vector<Eigen::Vector3d>& points) {
  Cells cells;
  for (const Eigen::Vector3d& point : points) cells[cell_key(point, kRadius)].push_back(point);
  EntropySum sum;
  const std::size_t step = points.size() / kPointsPerLocation + 1;
  for (std::size_t i = 0; i < points.size(); i += step) {
    if (points[i].norm() > kLocationRadius) continue;
    const PointMoments moments = neighbours_of(points[i], cells);
    if (moments.count < kMinNeighbours) continue;
    const double volume = (2.0 * kPi * M_E * moments.covariance()).determinant();
    if (!(volume > 0.0)) continue;
    sum.entropy += 0.5 * std::log(volume);
    sum.points += 1.0;
    sum.neighbours += moments.count;
  }
  return sum;
}

}  // namespace

MapEntropy mean_map_entropy(const KeyFramePoses& poses, CloudSource& clouds) {
  const std::size_t step = poses.poses.size() / kLocations + 1;
  EntropySum total;
  for (std::size_t location = 0; location < poses.poses.size(); location += step) {
    const EntropySum sum = entropy_of(points_around(poses.poses, location, clouds));
    total.entropy += sum.entropy;
    total.points += sum.points;
    total.neighbours += sum.neighbours;
  }
  if (total.points == 0.0) return {};
  return {total.entropy / total.points, kRadius, static_cast<std::size_t>(total.points),
          total.neighbours / total.points};
}

}  // namespace lidar_mapping::map_quality
