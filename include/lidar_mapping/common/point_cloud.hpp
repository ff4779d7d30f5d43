// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// A measured point: 16 bytes, so that it is one aligned load.
struct Point {
  float x = 0.0F;          ///< m
  float y = 0.0F;          ///< m
  float z = 0.0F;          ///< m
  float intensity = 0.0F;  ///< as the sensor gives it

  /// x y z, m.
  Eigen::Vector3f position() const { return {x, y, z}; }
};

/// Points and, where the sensor gives them, their times.
struct PointCloud {
  std::vector<Point> points;  ///< in the frame that the owner documents
  /// Seconds relative to the scan's stamp; empty if unknown or if all points refer to the stamp.
  std::vector<float> times;

  /// Number of points.
  std::size_t size() const { return points.size(); }
  /// There are no points.
  bool empty() const { return points.empty(); }
  /// Each point has a time.
  bool has_times() const { return !times.empty(); }
};

/// A shared cloud that is never changed; may be null.
using PointCloudPtr = std::shared_ptr<const PointCloud>;

/// One turn of the LiDAR, in its frame unless documented otherwise; `stamp` is the instant to which
/// points are deskewed, or to which cloud.times refer.
struct Scan {
  Stamp stamp = 0;   ///< the instant that the cloud belongs to
  PointCloud cloud;  ///< with times, or deskewed to the stamp
};

/// Points mapped from frame b to frame a (p_a = T_a_b p_b); times are kept.
PointCloud transformed(const PointCloud& cloud, const Pose& T_a_b);

}  // namespace lidar_mapping
