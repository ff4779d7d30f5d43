// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// The elevations at which a LiDAR has had returns, as slopes of the rays (their tangents). A scan
/// of another LiDAR also has points where this one cannot see.
class ElevationRange {
 public:
  /// Adds the points of a scan and the position of its LiDAR, in the same frame, m.
  void add(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& lidar);
  /// Whether a point lies within the range, seen from a position of the LiDAR; false for all points
  /// as long as no points were added.
  bool contains(const Eigen::Vector3f& point, const Eigen::Vector3f& lidar) const;

 private:
  float lowest_ = std::numeric_limits<float>::infinity();
  float highest_ = -std::numeric_limits<float>::infinity();
};

}  // namespace lidar_mapping::loop_closing
