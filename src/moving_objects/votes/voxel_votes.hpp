// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/moving_objects/transformed_points.hpp"

#include "votes/vote_count.hpp"

namespace lidar_mapping::moving_objects {

/// Keys of the voxels of points, and of the vertical columns in which these lie. Columns are
/// numbered by a pattern of kColumns that repeats itself; all voxels of a column have the same
/// number.
class VoxelKeys {
 public:
  /// By the format of their numbers, which have 16 bits.
  static constexpr std::size_t kColumns = std::size_t{1} << 16U;

  /// `voxel`: edge, m.
  VoxelKeys(const TransformedPoints& points, float voxel);

  VoxelKey of(std::size_t i) const {
    return voxel_key(
        voxel_index(scale_ * Eigen::Vector3f(points_.x[i], points_.y[i], points_.z[i])));
  }
  std::uint16_t column_of(std::size_t i) const { return columns_[i]; }
  static std::uint16_t column_of_key(VoxelKey key) {
    const VoxelIndex voxel = voxel_index(key);
    return column(voxel.x(), voxel.y());
  }

 private:
  // The square root of kColumns, so that the number of a column fills 16 bits.
  static constexpr unsigned kWidth = 256;
  static std::uint16_t column(int x, int y) {
    return static_cast<std::uint16_t>(static_cast<unsigned>(x) % kWidth * kWidth +
                                      static_cast<unsigned>(y) % kWidth);
  }

  const TransformedPoints& points_;
  float scale_;
  std::vector<std::uint16_t> columns_;
};

/// Filter of columns around some voxels, which saves most look-ups of other points.
class ColumnFilter {
 public:
  /// Adds the column of a voxel and those up to `max_distance` columns away.
  void add_around(VoxelKey key, int max_distance);
  bool may_contain(std::uint16_t column) const { return occupied_[column]; }

 private:
  std::bitset<VoxelKeys::kColumns> occupied_;
};

/// Numbers of points in the 3x3x3 small voxels around candidates.
class NeighbourCounter {
 public:
  NeighbourCounter(const TransformedPoints& points, const std::vector<Vote>& votes);

  /// Number of points around the candidate, itself included.
  int around(std::size_t candidate) const;

 private:
  VoxelKeys keys_;
  std::unordered_map<VoxelKey, int, VoxelKeyHash> counts_;
};

/// Vote counts of the 3x3x3 voxels around each voxel that contains a candidate or touches such a
/// voxel.
class VoteBlocks {
 public:
  VoteBlocks(const TransformedPoints& points, const std::vector<Vote>& votes);

  bool empty() const { return blocks_.empty(); }

  /// Whether the 3x3x3 voxels around the i-th point move as a whole.
  bool is_moving_around(std::size_t i) const {
    return near_.may_contain(keys_.column_of(i)) && is_moving(keys_.of(i));
  }

 private:
  using Counts = std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash>;

  bool is_moving(VoxelKey key) const;
  /// Vote counts of all voxels that may belong to a block, and of some others.
  Counts counted_voxels(const std::vector<Vote>& votes) const;

  VoxelKeys keys_;
  Counts blocks_;
  ColumnFilter near_;
};

}  // namespace lidar_mapping::moving_objects
