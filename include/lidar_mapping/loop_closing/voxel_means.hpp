// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::loop_closing {

/// Thins points while they come: the mean of those in each voxel, in the order of the voxels' first
/// points. Positions alone, in single precision, and memory that serves again and again.
class VoxelMeans {
 public:
  VoxelMeans();

  /// Forgets all points. `leaf`: edge of a voxel, m; with 0 every point stays.
  void reset(double leaf);
  /// Points that are not finite, or further from the origin than any LiDAR sees, are left out.
  void add(const Eigen::Vector3f& p);
  std::vector<Eigen::Vector3f> points();

 private:
  struct Voxel {
    VoxelKey key;
    float count;
    Eigen::Vector3f sum;  // of the offsets from the corner of the cell: small, so float will do
  };
  /// A point on its way to its voxel. A few wait for each other: the processor often guesses wrong
  /// where one of them goes, and then it should not have begun with the numbers of the next ones.
  struct PendingPoint {
    VoxelKey key;
    Eigen::Vector3f offset;
  };
  static constexpr std::size_t kMaxPending = 32;

  void process_pending();
  std::uint32_t find_or_add(VoxelKey key);
  std::uint32_t& slot_of(VoxelKey key);
  void grow();

  float leaf_ = 0.0F;
  float inverse_leaf_ = 0.0F;
  std::array<PendingPoint, kMaxPending> pending_;
  std::size_t pending_count_ = 0;
  std::vector<Voxel> voxels_;
  std::vector<std::uint32_t> slots_;  // a hash table with linear probing, at most half full
};

}  // namespace lidar_mapping::loop_closing
