// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// 16 bytes, so that a point is one aligned load. Metres; intensity as the sensor gives it.
struct Point {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  float intensity = 0.0F;

  Eigen::Vector3f position() const { return {x, y, z}; }
};

/// Points and, where the sensor gives them, their times.
struct PointCloud {
  std::vector<Point> points;
  /// Seconds relative to the scan's stamp; empty if unknown or if all points refer to the stamp.
  std::vector<float> times;

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  bool has_times() const { return !times.empty(); }
};

using PointCloudPtr = std::shared_ptr<const PointCloud>;

/// One turn of the LiDAR, in its frame or as said; `stamp` is the instant to which points are
/// deskewed, or to which cloud.times refer.
struct Scan {
  Stamp stamp = 0;
  PointCloud cloud;
};

/// Points mapped from frame b to frame a (p_a = T_a_b p_b); times are kept.
PointCloud transformed(const PointCloud& cloud, const Pose& T_a_b);

}  // namespace lidar_mapping
