// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/voxel_filter.hpp"

#include <cstdint>

namespace lidar_mapping {

namespace {

/// 64 bits for each axis, unlike VoxelKey: the filter serves clouds in any coordinates, UTM with
/// small voxels among them.
struct Cell {
  std::int64_t x, y, z;
  bool operator==(const Cell& other) const { return x == other.x && y == other.y && z == other.z; }
};

std::size_t hash_of(const Cell& cell) {
  std::uint64_t hash = static_cast<std::uint64_t>(cell.x) * 0x9E3779B97F4A7C15ULL;
  hash ^= static_cast<std::uint64_t>(cell.y) * 0xC2B2AE3D27D4EB4FULL;
  hash ^= static_cast<std::uint64_t>(cell.z) * 0x165667B19E3779F9ULL;
  return static_cast<std::size_t>(hash ^ (hash >> 29));
}

/// Numbers cells in the order in which they are first seen: a flat table with linear probing, never
/// more than half full.
class CellNumbers {
 public:
  explicit CellNumbers(std::size_t most_cells) {
    std::size_t capacity = 16;
    while (capacity < 2 * most_cells) capacity *= 2;
    slots_.assign(capacity, kFree);
  }

  /// The number of the cell; the next free one if it is new. Neighbours in a cloud often share one.
  std::size_t number_of(const Cell& cell) {
    if (!cells_.empty() && cells_[last_] == cell) return last_;
    return last_ = find_or_add(cell);
  }

 private:
  static constexpr std::uint32_t kFree = 0xFFFFFFFFU;  // chosen: no index, as there are fewer cells

  std::size_t find_or_add(const Cell& cell) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash_of(cell) & mask;
    while (slots_[slot] != kFree && !(cells_[slots_[slot]] == cell)) slot = (slot + 1) & mask;
    if (slots_[slot] == kFree) {
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
      cells_.push_back(cell);
    }
    return slots_[slot];
  }

  std::vector<std::uint32_t> slots_;
  std::vector<Cell> cells_;
  std::size_t last_ = 0;
};

/// Offsets are summed relative to the voxel's first point: sums stay small, so double means exact.
struct Sums {
  Eigen::Vector3d first;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  double intensity = 0.0;
  double time = 0.0;
  std::size_t count = 0;
};

}  // namespace

PointCloud voxel_filtered(const PointCloud& cloud, double resolution) {
  if (resolution <= 0.0) return cloud;
  CellNumbers numbers(cloud.size());
  std::vector<Sums> voxels;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& point = cloud.points[i];
    const Eigen::Vector3d p = point.position().cast<double>();
    if (!p.allFinite()) continue;
    const Eigen::Vector3d scaled = (p / resolution).array().floor();
    const Cell cell{static_cast<std::int64_t>(scaled.x()), static_cast<std::int64_t>(scaled.y()),
                    static_cast<std::int64_t>(scaled.z())};
    const std::size_t number = numbers.number_of(cell);
    if (number == voxels.size()) {
      voxels.emplace_back();
      voxels.back().first = p;
    }
    Sums& sums = voxels[number];
    sums.offset += p - sums.first;
    sums.intensity += point.intensity;
    if (cloud.has_times()) sums.time += cloud.times[i];
    ++sums.count;
  }
  PointCloud result;
  result.points.reserve(voxels.size());
  for (const Sums& sums : voxels) {
    const double inverse_count = 1.0 / static_cast<double>(sums.count);
    const Eigen::Vector3f centroid = (sums.first + inverse_count * sums.offset).cast<float>();
    result.points.push_back({centroid.x(), centroid.y(), centroid.z(),
                             static_cast<float>(inverse_count * sums.intensity)});
    if (cloud.has_times()) result.times.push_back(static_cast<float>(inverse_count * sums.time));
  }
  return result;
}

}  // namespace lidar_mapping
