// SPDX-License-Identifier: BSD-3-Clause
#include "files/point_octree.hpp"

#include <algorithm>
#include <limits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

constexpr std::int64_t kSpan = OctreeOptions::kSpan;

// Points. A node with no more than that is not divided. Chosen: about half of what a node of a
// town takes with the span above, 1 MB, which a browser loads in a moment.
constexpr std::size_t kUndividedPoints = 40'000;
// Points. A child with fewer leaves them to its parent. Chosen: a file of less than a disk block's
// worth of points costs more to ask for than to load.
constexpr std::size_t kLeastPoints = 500;

using Children = std::array<std::vector<StoredPoint>, 8>;

/// For each cell of a node the point that is nearest to the centre of the cell; of equally near
/// ones the first.
class CellSelection {
 public:
  CellSelection(const OctreeCube& cube, const OctreeKey& key)
      : corner_(cube.corner_of(key)),
        edge_(cube.edge_of(key)),
        nearest_(static_cast<std::size_t>(kSpan * kSpan * kSpan)) {}

  void offer(std::size_t number, const StoredPoint& point) {
    const CellPosition position = position_in_cell(point);
    Nearest& nearest = nearest_[position.cell];
    if (position.distance < nearest.distance) {
      nearest = {position.distance, static_cast<std::uint32_t>(number)};
    }
  }
  bool is_selected(std::size_t number, const StoredPoint& point) const {
    return nearest_[position_in_cell(point).cell].number == number;
  }
  /// The octant of the node in which a point lies.
  unsigned octant_of(const StoredPoint& point) const {
    unsigned octant = 0;
    for (unsigned i = 0; i < 3; ++i) {
      if (2 * (point.position[i] - corner_[i]) >= edge_) octant |= 1U << i;
    }
    return octant;
  }

 private:
  struct CellPosition {
    std::size_t cell = 0;
    float distance = 0.0F;  ///< From the centre of the cell, squared; the unit is that of the node.
  };
  struct Nearest {
    float distance = std::numeric_limits<float>::infinity();
    std::uint32_t number = 0;
  };

  CellPosition position_in_cell(const StoredPoint& point) const {
    CellPosition position;
    double distance = 0.0;
    for (std::size_t i = 3; i-- > 0;) {
      const std::int64_t scaled = (point.position[i] - corner_[i]) * kSpan;
      const std::int64_t cell = scaled / edge_;
      const double offset = static_cast<double>(2 * (scaled - cell * edge_) - edge_);
      distance += offset * offset;
      position.cell =
          position.cell * static_cast<std::size_t>(kSpan) + static_cast<std::size_t>(cell);
    }
    position.distance = static_cast<float>(distance);
    return position;
  }

  std::array<std::int64_t, 3> corner_;
  std::int64_t edge_;
  std::vector<Nearest> nearest_;
};

class Divider {
 public:
  Divider(const OctreeCube& cube, const OctreeOptions& options,
          const std::filesystem::path& directory, const OctreeSink& sink)
      : cube_(cube), options_(options), directory_(directory), sink_(sink) {}

  void divide_stored(const OctreeKey& key, PointSpool points) const {
    // What is not divided at all is not divided on the disk either.
    const std::size_t most = std::max(options_.points_in_memory, kUndividedPoints);
    if (points.size() <= most || key.depth == OctreeCube::kMaxDepth) {
      return divide_in_memory(key, points);
    }
    std::vector<PointSpool> children = split(key, std::move(points));
    for (unsigned octant = 0; octant < 8; ++octant) {
      divide_stored(key.child(octant), std::move(children[octant]));
    }
  }

 private:
  void divide_in_memory(const OctreeKey& key, const PointSpool& points) const {
    std::vector<StoredPoint> in_memory;
    points.append_to(in_memory);
    divide(key, std::move(in_memory), options_.threads);
  }

  /// Passes the points of the node to the sink, and returns those of its children. The files of the
  /// node are gone then.
  std::vector<PointSpool> split(const OctreeKey& key, PointSpool&& node) const {
    const PointSpool points = std::move(node);
    CellSelection selection(cube_, key);
    points.for_each([&](std::size_t i, const StoredPoint& point) { selection.offer(i, point); });
    std::vector<StoredPoint> own;
    std::vector<PointSpool> children;
    for (unsigned octant = 0; octant < 8; ++octant) children.emplace_back(directory_);
    points.for_each([&](std::size_t i, const StoredPoint& point) {
      if (selection.is_selected(i, point)) return own.push_back(point);
      children[selection.octant_of(point)].add(point);
    });
    for (PointSpool& child : children) {
      if (child.size() >= kLeastPoints) continue;
      child.append_to(own);
      child = PointSpool(directory_);
    }
    sink_(key, own);
    return children;
  }

  void divide(const OctreeKey& key, std::vector<StoredPoint> points, int threads) const {
    if (points.size() <= kUndividedPoints || key.depth == OctreeCube::kMaxDepth) {
      if (!points.empty()) sink_(key, points);
      return;
    }
    Children children = split(key, std::move(points));
    parallel_chunks(8, 1, threads, [&](std::size_t octant, std::size_t) {
      const auto number = static_cast<unsigned>(octant);
      divide(key.child(number), std::move(children[octant]), 1);
    });
  }

  Children split(const OctreeKey& key, std::vector<StoredPoint> points) const {
    CellSelection selection(cube_, key);
    for (std::size_t i = 0; i < points.size(); ++i) selection.offer(i, points[i]);
    std::vector<StoredPoint> own;
    Children children;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool is_own = selection.is_selected(i, points[i]);
      (is_own ? own : children[selection.octant_of(points[i])]).push_back(points[i]);
    }
    for (std::vector<StoredPoint>& child : children) {
      if (child.size() >= kLeastPoints) continue;
      own.insert(own.end(), child.begin(), child.end());
      child.clear();
    }
    sink_(key, own);
    return children;
  }

  const OctreeCube& cube_;
  const OctreeOptions& options_;
  const std::filesystem::path& directory_;
  const OctreeSink& sink_;
};

}  // namespace

std::string OctreeKey::name() const {
  return std::to_string(depth) + "-" + std::to_string(x) + "-" + std::to_string(y) + "-" +
         std::to_string(z);
}

OctreeKey OctreeKey::child(unsigned octant) const {
  return {depth + 1, 2 * x + (octant & 1U), 2 * y + (octant >> 1U & 1U), 2 * z + (octant >> 2U)};
}

OctreeCube::OctreeCube(const std::array<std::int32_t, 3>& low,
                       const std::array<std::int32_t, 3>& high) {
  constexpr std::int64_t kUnit = std::int64_t{1} << kMaxDepth;  // mm, by definition: 16 m
  std::int64_t extent = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    extent = std::max(extent, std::int64_t{high[i]} - std::int64_t{low[i]});
  }
  edge = (extent / kUnit + 1) * kUnit;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t size = std::int64_t{high[i]} - std::int64_t{low[i]};
    corner[i] = low[i] - (edge - size) / 2;
  }
}

std::array<std::int64_t, 3> OctreeCube::corner_of(const OctreeKey& key) const {
  const std::int64_t node_edge = edge_of(key);
  return {corner[0] + key.x * node_edge, corner[1] + key.y * node_edge,
          corner[2] + key.z * node_edge};
}

void divide_into_octree(PointSpool points, const OctreeCube& cube, const OctreeOptions& options,
                        const std::filesystem::path& directory, const OctreeSink& sink) {
  constexpr std::size_t kMostPoints = std::numeric_limits<std::uint32_t>::max();
  if (points.size() > kMostPoints) {
    throw InputError("the map has " + std::to_string(points.size()) + " points, and one octree " +
                     std::to_string(kMostPoints) + " at most; divide it with --crop");
  }
  Divider(cube, options, directory, sink).divide_stored({}, std::move(points));
}

}  // namespace lidar_mapping::map
