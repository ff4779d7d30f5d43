// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/elevation_shift.hpp"

namespace lidar_mapping {
namespace {

double azimuth(const Point& p) { return std::atan2(p.y, p.x); }

double elevation(const Point& p) { return std::atan2(p.z, std::hypot(p.x, p.y)); }

/// Points around the sensor, above and below it.
PointCloud some_points() {
  PointCloud cloud;
  for (int i = 0; i < 100; ++i) {
    const auto at = static_cast<float>(i);
    cloud.points.push_back({30.0F * std::cos(at), 20.0F * std::sin(at), 0.1F * at - 5.0F, at});
  }
  return cloud;
}

TEST(ElevationShift, TurnsPointsInTheirVerticalPlanes) {
  for (const double angle : {0.1, -0.004}) {
    const PointCloud before = some_points();
    PointCloud after = before;
    rotate_upwards(after, angle);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Point& p = before.points[i];
      const Point& q = after.points[i];
      EXPECT_NEAR(q.position().norm(), p.position().norm(), 1e-4);
      EXPECT_NEAR(azimuth(q), azimuth(p), 1e-5);
      EXPECT_NEAR(elevation(q), elevation(p) + angle, 1e-5);
      EXPECT_EQ(q.intensity, p.intensity);
    }
  }
}

TEST(ElevationShift, OfNothingLeavesEvenDamagedPoints) {
  PointCloud cloud;
  cloud.points = {{1.0F, 2.0F, std::nanf(""), 0.0F}};
  rotate_upwards(cloud, 0.0);
  EXPECT_EQ(cloud.points[0].x, 1.0F);
  EXPECT_EQ(cloud.points[0].y, 2.0F);
}

}  // namespace
}  // namespace lidar_mapping
