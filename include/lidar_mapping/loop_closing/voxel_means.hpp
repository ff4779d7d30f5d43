// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/keyed_list.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::loop_closing {

/// Voxel filter that takes points one by one. The result is the mean of the points in each voxel,
/// in the order of the voxels' first points. It filters positions only, in single precision, and
/// reuses its memory.
class VoxelMeans {
 public:
  /// Removes all points. `leaf` is the edge length of a voxel, m; with 0, and before the first
  /// call, every point is kept.
  void reset(double leaf);
  /// Adds a point. Points that are not finite, or that are further than 50 km from the origin along
  /// an axis, are ignored.
  void add(const Eigen::Vector3f& p);
  /// The mean of each voxel, m.
  std::vector<Eigen::Vector3f> points();
  /// All three for a whole cloud: reset(), add() for each of its points, and points().
  std::vector<Eigen::Vector3f> filtered(const PointCloud& cloud, double leaf);

 private:
  struct Voxel {
    VoxelKey key = 0;
    float count = 0.0F;
    // Of the offsets from the corner of the cell: small, so that float is precise enough.
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  };
  /// A point that is not added to its voxel yet. Points are added in small batches: the processor
  /// often mispredicts the branches of the hash table, and the computation of the next keys should
  /// not be lost with each misprediction.
  struct PendingPoint {
    VoxelKey key;
    Eigen::Vector3f offset;
  };
  /// Points whose voxels are looked up together, so that the waits for memory overlap. Chosen; the
  /// sums do not depend on it.
  static constexpr std::size_t kMaxPending = 32;

  void process_pending();

  float leaf_ = 0.0F;
  float inverse_leaf_ = 0.0F;
  std::array<PendingPoint, kMaxPending> pending_;
  std::size_t pending_count_ = 0;
  KeyedList<Voxel, VoxelKeyHash> voxels_;
  std::vector<Eigen::Vector3f> kept_;  // every point, if there are no voxels
};

}  // namespace lidar_mapping::loop_closing
