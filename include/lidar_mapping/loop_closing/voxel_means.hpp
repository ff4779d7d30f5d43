#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// Thins points while they come: the mean of those in each voxel, in the order of the voxels' first
/// points. Positions alone, in single precision, and memory that serves again and again.
class VoxelMeans {
 public:
  VoxelMeans();

  /// Forgets all points. `leaf`: edge of a voxel, m; with 0 every point stays.
  void restart(double leaf);
  /// Points that are not finite, or further from the origin than any LiDAR sees, are left out.
  void add(const Eigen::Vector3f& p);
  std::vector<Eigen::Vector3f> points() const;

 private:
  struct Voxel {
    Eigen::Vector3i cell;
    float count;
    Eigen::Vector3f sum;  // of the offsets from the corner of the cell: small, so float will do
  };
  std::uint32_t find_or_add(const Eigen::Vector3i& cell);
  std::uint32_t& slot_of(const Eigen::Vector3i& cell);
  void grow();

  float leaf_ = 0.0F;
  float per_leaf_ = 0.0F;
  std::vector<Voxel> voxels_;
  std::vector<std::uint32_t> slots_;  // a hash table with linear probing, at most half full
};

}  // namespace lidar_mapping::loop_closing
