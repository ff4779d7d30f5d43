// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/ground_area.hpp"

namespace lidar_mapping::moving_objects {
namespace {

using Cell = std::pair<int, int>;

Cell cell_of(const Eigen::Vector3d& p_map) {
  return {static_cast<int>(std::floor(p_map.x() / GroundArea::kColumnSize)),
          static_cast<int>(std::floor(p_map.y() / GroundArea::kColumnSize))};
}

/// Some points around a location that is far from the origin, one of them out of range.
PointCloud some_points(const Eigen::Vector3d& p_base, float max_range) {
  std::mt19937 engine(3);
  std::normal_distribution<double> offset(0.0, 12.0);
  PointCloud cloud;
  for (int i = 0; i < 200; ++i) {
    // In the middle of a column, where rounding of floats does not matter.
    const auto middle = [&](double at) {
      return (std::floor((at + offset(engine)) / GroundArea::kColumnSize) + 0.5) *
                 GroundArea::kColumnSize -
             at;
    };
    cloud.points.push_back({static_cast<float>(middle(p_base.x())),
                            static_cast<float>(middle(p_base.y())), 0.0F, 0.0F});
  }
  cloud.points.push_back({2.0F * max_range, 0.0F, 0.0F, 0.0F});
  return cloud;
}

TEST(GroundArea, NumbersColumnsAroundPoints) {
  constexpr float kRange = 100.0F;
  Pose T_map_base;
  T_map_base.translation = {-1234.5, 777.7, 3.0};
  const PointCloud cloud = some_points(T_map_base.translation, kRange);
  const GroundArea area(TransformedPoints(cloud, T_map_base), kRange);
  std::set<Cell> expected;
  for (std::size_t i = 0; i + 1 < cloud.size(); ++i) {
    const Cell cell = cell_of(T_map_base * cloud.points[i].position().cast<double>());
    EXPECT_EQ(area.column_of(i), area.index_of({cell.first, cell.second})) << i;
    const auto rows = area.rows_around(area.column_of(i));
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const Cell near = {cell.first + dx, cell.second + dy};
        expected.insert(near);
        EXPECT_EQ(area.index_of({near.first, near.second}),
                  rows[dy + 2] + static_cast<std::uint32_t>(dx + 2));
      }
    }
  }
  EXPECT_EQ(area.column_of(cloud.size() - 1), GroundArea::kOutside);
  EXPECT_EQ(area.size(), expected.size());
  const Cell low = *expected.begin();
  EXPECT_EQ(area.index_of({low.first - 1, low.second}), GroundArea::kOutside);
}

TEST(GroundArea, IsEmptyWithoutPoints) {
  const GroundArea area(TransformedPoints({}, Pose()));
  EXPECT_EQ(area.size(), 0U);
  EXPECT_EQ(area.index_of({0, 0}), GroundArea::kOutside);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
