// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::test {

/// The points of the clouds in all example files: around the sensor, 10 m away.
inline std::vector<Point> example_points() {
  std::vector<Point> points;
  for (int i = 0; i < 60; ++i) {
    const auto f = static_cast<float>(i);
    points.push_back({10.0F * std::cos(f), 10.0F * std::sin(f), 0.1F * f, f});
  }
  return points;
}

}  // namespace lidar_mapping::test
