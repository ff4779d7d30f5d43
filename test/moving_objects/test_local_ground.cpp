// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/local_ground.hpp"

namespace lidar_mapping::moving_objects {
namespace {

constexpr double kColumnSize = 0.6;  // m, side of a column
constexpr double kGrade = 0.3;
const Eigen::Vector2d kCar(3.9, -2.1);  // m, middle of a column
constexpr float kRoof = 1.5F;           // m above the street
// m, at the ends of the street half of the surroundings is unobserved
constexpr float kEvaluatedRange = 8.0F;

using Slope = Eigen::Vector2d;  ///< Grade along x and y.

double street(const Slope& slope, double x, double y) { return slope.dot(Eigen::Vector2d(x, y)); }

/// A sloping street observed every 0.2 m, except in the column of the car, of which only the roof
/// is observed.
TransformedPoints sloping_street(const Slope& slope) {
  PointCloud cloud;
  const auto add = [&cloud](double x, double y, double z) {
    cloud.points.push_back(
        {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0.0F});
  };
  for (int i = -50; i < 50; ++i) {
    for (int j = -50; j < 50; ++j) {
      const double x = 0.1 + 0.2 * i;
      const double y = 0.1 + 0.2 * j;
      const bool is_car =
          std::max(std::abs(x - kCar.x()), std::abs(y - kCar.y())) < kColumnSize / 2;
      add(x, y, street(slope, x, y) + (is_car ? kRoof : 0.0));
    }
  }
  return TransformedPoints(cloud, Pose());
}

struct Heights {
  float street;  ///< Largest height of points of the street above the ground, m.
  float roof;    ///< Least height of points of the roof above the ground, m.
};

Heights heights(const Slope& slope) {
  const TransformedPoints points = sloping_street(slope);
  const GroundArea area(points);
  LocalGround ground(area);
  ground.add(ground_columns(points));
  Heights result{0.0F, kRoof * 10};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f point(points.x[i], points.y[i], points.z[i]);
    if (point.head<2>().cwiseAbs().maxCoeff() > kEvaluatedRange) continue;
    const float above = ground.height_above(point.z(), area.column_of(i));
    const bool is_roof = point.z() > street(slope, point.x(), point.y()) + 0.5;
    if (is_roof) {
      result.roof = std::min(result.roof, above);
    } else {
      result.street = std::max(result.street, above);
    }
  }
  return result;
}

TEST(LocalGround, LiesBelowCarOnSlopeOfAnyDirection) {
  for (const Slope& slope :
       {Slope(kGrade, 0.0), Slope(-kGrade, 0.0), Slope(0.0, kGrade), Slope(0.0, -kGrade)}) {
    const Heights result = heights(slope);
    // A column's points lie up to 0.4 m uphill of its lowest ones.
    EXPECT_NEAR(result.street, 0.4 * kGrade, 0.01) << slope.transpose();
    // The lowest quarter of the columns around the car begins one column downhill.
    EXPECT_NEAR(result.roof, kRoof + kColumnSize * kGrade, 0.02) << slope.transpose();
  }
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
