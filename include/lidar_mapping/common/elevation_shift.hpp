// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping {

/// Turns points upwards by an angle (rad) about the horizontal axis that is normal to their beam,
/// as a sensor with wrong elevations wants it. Points are in the sensor's axes.
class ElevationShift {
 public:
  /// `angle`: rad, positive upwards.
  explicit ElevationShift(double angle)
      : cosine_(static_cast<float>(std::cos(angle))), sine_(static_cast<float>(std::sin(angle))) {}

  /// Turns one point, in place: its range and azimuth stay. A point on the vertical axis, which has
  /// no azimuth, stays on the axis.
  void operator()(float& x, float& y, float& z) const {
    const float horizontal = std::sqrt(x * x + y * y);
    const float scale = horizontal > 0.0F ? (horizontal * cosine_ - z * sine_) / horizontal : 1.0F;
    z = z * cosine_ + horizontal * sine_;
    x *= scale;
    y *= scale;
  }

 private:
  float cosine_;
  float sine_;
};

/// Turns all points of a cloud so, in place; an angle of zero leaves them as they are, bit for bit.
inline void rotate_upwards(PointCloud& cloud, double angle) {
  if (angle == 0.0) return;
  const ElevationShift shift(angle);
  for (Point& p : cloud.points) shift(p.x, p.y, p.z);
}

}  // namespace lidar_mapping
