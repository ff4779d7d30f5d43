// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/voxel_filter.hpp"

#include <cstdint>

#include "lidar_mapping/common/keyed_list.hpp"

namespace lidar_mapping {

namespace {

/// 64 bits for each axis, unlike VoxelKey: the filter serves clouds in any coordinates, UTM with
/// small voxels among them.
struct Cell {
  std::int64_t x, y, z;
  bool operator==(const Cell& other) const { return x == other.x && y == other.y && z == other.z; }
};

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = static_cast<std::uint64_t>(cell.x) * 0x9E3779B97F4A7C15ULL;
    hash ^= static_cast<std::uint64_t>(cell.y) * 0xC2B2AE3D27D4EB4FULL;
    hash ^= static_cast<std::uint64_t>(cell.z) * 0x165667B19E3779F9ULL;
    return static_cast<std::size_t>(hash ^ (hash >> 29));
  }
};

/// Offsets are summed relative to the voxel's first point: sums stay small, so double means exact.
struct Sums {
  Cell key;
  Eigen::Vector3d first;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  double intensity = 0.0;
  double time = 0.0;
  std::size_t count = 0;
};

}  // namespace

PointCloud voxel_filtered(const PointCloud& cloud, double resolution) {
  if (resolution <= 0.0) return cloud;
  KeyedList<Sums, CellHash> voxels(cloud.size());
  Sums* voxel = nullptr;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& point = cloud.points[i];
    const Eigen::Vector3d p = point.position().cast<double>();
    if (!p.allFinite()) continue;
    const Eigen::Vector3d scaled = (p / resolution).array().floor();
    const Cell cell{static_cast<std::int64_t>(scaled.x()), static_cast<std::int64_t>(scaled.y()),
                    static_cast<std::int64_t>(scaled.z())};
    // Neighbours in a cloud often share a voxel.
    if (voxel == nullptr || !(voxel->key == cell)) voxel = &voxels.find_or_add(cell);
    if (voxel->count == 0) voxel->first = p;
    voxel->offset += p - voxel->first;
    voxel->intensity += point.intensity;
    if (cloud.has_times()) voxel->time += cloud.times[i];
    ++voxel->count;
  }
  PointCloud result;
  result.points.reserve(voxels.size());
  for (const Sums& sums : voxels.elements()) {
    const double inverse_count = 1.0 / static_cast<double>(sums.count);
    const Eigen::Vector3f centroid = (sums.first + inverse_count * sums.offset).cast<float>();
    result.points.push_back({centroid.x(), centroid.y(), centroid.z(),
                             static_cast<float>(inverse_count * sums.intensity)});
    if (cloud.has_times()) result.times.push_back(static_cast<float>(inverse_count * sums.time));
  }
  return result;
}

}  // namespace lidar_mapping
