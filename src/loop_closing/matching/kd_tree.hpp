// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// Kd-tree of points that do not change, by nanoflann. It is built once in O(n log n). Searches are
/// thread-safe.
class KdTree {
 public:
  struct Neighbour {
    std::uint32_t index = 0;  ///< in points()
    float squared_distance = 0.0F;
  };

  /// The nearest point, and the distance of the second nearest one.
  struct NearestWithSecond {
    Neighbour nearest;
    float second_squared_distance = 0.0F;  ///< square of the limit if there is none within it
  };

  /// A tree without points.
  KdTree();
  explicit KdTree(std::vector<Eigen::Vector3f> points);
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;
  ~KdTree();

  const std::vector<Eigen::Vector3f>& points() const;
  /// The nearest point, if it is closer than `limit` (m).
  std::optional<Neighbour> nearest(const Eigen::Vector3f& p, float limit) const;
  /// The same, together with the distance of the second nearest point.
  std::optional<NearestWithSecond> nearest_with_second(const Eigen::Vector3f& p, float limit) const;
  /// The `count` nearest points, nearest first; fewer if there are not so many.
  std::vector<Neighbour> nearest(const Eigen::Vector3f& p, std::size_t count) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace lidar_mapping::loop_closing
