// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// Kd-tree of points that do not change. It is built once in O(n log n). The points are reordered
/// so that neighbours are close in memory; all indices refer to this order. Searches are
/// thread-safe.
class KdTree {
 public:
  struct Neighbour {
    std::uint32_t index = 0;
    float squared_distance = 0.0F;
  };

  /// The nearest point, and the distance of the second nearest one.
  struct NearestWithSecond {
    Neighbour nearest;
    float second_squared_distance = 0.0F;  ///< square of the limit if there is none within it
  };

  KdTree() = default;
  explicit KdTree(std::vector<Eigen::Vector3f> points);

  const std::vector<Eigen::Vector3f>& points() const { return points_; }
  /// The nearest point, if it is closer than `limit` (m).
  std::optional<Neighbour> nearest(const Eigen::Vector3f& p, float limit) const;
  /// The same, together with the distance of the second nearest point.
  std::optional<NearestWithSecond> nearest_with_second(const Eigen::Vector3f& p, float limit) const;
  /// The `count` nearest points, nearest first; fewer if there are not so many.
  std::vector<Neighbour> nearest(const Eigen::Vector3f& p, std::size_t count) const;

 private:
  struct Node {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t right = 0;  ///< the left child follows its parent; 0 marks a leaf
    int axis = 0;
    float split = 0.0F;
  };

  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  template <typename Visit>
  void scan_leaf(const Node& leaf, const Eigen::Vector3f& p, Visit& visit) const;
  template <typename Visit>
  void search(const Eigen::Vector3f& p, Visit& visit) const;
  template <typename Visit>
  void search(std::uint32_t node, const Eigen::Vector3f& p, Eigen::Vector3f& offset,
              Visit& visit) const;

  std::vector<Eigen::Vector3f> points_;
  /// The points by axis, padded for the last lanes.
  std::array<std::vector<float>, 3> coordinates_;
  std::vector<Node> nodes_;
};

}  // namespace lidar_mapping::loop_closing
