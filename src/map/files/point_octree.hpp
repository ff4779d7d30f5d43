// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

#include "files/point_spool.hpp"

namespace lidar_mapping::map {

/// A node of an octree: its depth, and its number along each axis among the nodes of that depth.
struct OctreeKey {
  int depth = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;

  /// "depth-x-y-z", as Entwine names nodes.
  std::string name() const;
  /// The child in the octant whose bits 0, 1 and 2 say whether it is the upper half in x, y and z.
  OctreeKey child(unsigned octant) const;
  bool operator<(const OctreeKey& other) const {
    return std::tie(depth, x, y, z) < std::tie(other.depth, other.x, other.y, other.z);
  }
};

/// The cube of the root, in millimetres of a MillimetreFrame. Its edge can be halved kMaxDepth
/// times, so that the borders of all nodes are whole millimetres. A point on a border belongs to
/// the upper node.
struct OctreeCube {
  /// The deepest level, and the finest edge of a node is 1 mm. Chosen: with the whole edge of a
  /// town, nodes of a metre; a node at this depth takes all points that are left.
  static constexpr int kMaxDepth = 14;

  /// A cube around points from `low` to `high` (inclusive), with the same centre.
  OctreeCube(const std::array<std::int32_t, 3>& low, const std::array<std::int32_t, 3>& high);

  std::int64_t edge_of(const OctreeKey& key) const { return edge >> key.depth; }
  std::array<std::int64_t, 3> corner_of(const OctreeKey& key) const;

  std::array<std::int64_t, 3> corner{};  ///< Lower corner.
  std::int64_t edge = 0;
};

/// How points are distributed to the nodes.
struct OctreeOptions {
  /// Cells along the edge of a node. Chosen: 10,000 to 50,000 points in a node of a town. A node
  /// takes at most one point of each from what its ancestors left, so its level of detail is its
  /// edge divided by this.
  static constexpr std::int64_t kSpan = 128;
  std::size_t points_in_memory = 4'000'000;  ///< A node with more is divided on the disk.
  int threads = 0;                           ///< Upper limit of threads; 0: all cores.
};

/// Receives the points of a node. Called by several threads at the same time, once for each node
/// that has points; a node comes after its ancestors.
using OctreeSink = std::function<void(const OctreeKey&, const std::vector<StoredPoint>&)>;

/// Distributes the points to an octree of levels of detail: each point lies in one node, and the
/// points of a node and all its ancestors together are a picture of its cube that is twice as fine
/// as that of its parent. The result depends on the points and their order alone. Nodes with more
/// than `points_in_memory` points are divided in unnamed files in `directory`. The points are
/// consumed. Throws FileError, and InputError for more points than 32 bits count.
void divide_into_octree(PointSpool points, const OctreeCube& cube, const OctreeOptions& options,
                        const std::filesystem::path& directory, const OctreeSink& sink);

}  // namespace lidar_mapping::map
