// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <tuple>

#include <gtest/gtest.h>

#include "made_map.hpp"
#include "near.hpp"
#include "open_ground.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map_import {
namespace {

using test::near;

std::vector<float> heights_between(float low, float high) {
  std::vector<float> heights;
  for (int i = 0; low + 0.2F * static_cast<float>(i) <= high; ++i) {
    heights.push_back(low + 0.2F * static_cast<float>(i));
  }
  return heights;
}

TEST(GroundHeights, OfAFlatStreetAreItsHeight) {
  EXPECT_EQ(ground_heights({0.02F, 0.0F, 0.03F, 0.01F}), std::vector<float>{0.03F});
  EXPECT_TRUE(ground_heights({}).empty());
}

TEST(GroundHeights, HaveOneForEachStorey) {
  const std::vector<float> ceiling_and_floor = {0.0F, 0.02F, 2.5F, 2.52F, 2.7F, 2.72F};
  EXPECT_EQ(ground_heights(ceiling_and_floor), (std::vector<float>{0.02F, 2.72F}));
}

TEST(GroundHeights, OfAWallAreAtItsTopAlone) {
  const std::vector<float> grounds = ground_heights(heights_between(0.0F, 3.0F));
  ASSERT_EQ(grounds.size(), 1U);
  EXPECT_GT(grounds[0], 2.3F);
}

TEST(GroundHeights, NeedHeadroom) {
  std::vector<float> under_a_truck = {0.0F, 0.02F, 0.03F, 1.2F, 1.22F, 1.25F};
  EXPECT_GT(ground_heights(under_a_truck).at(0), 1.0F);
  under_a_truck.insert(under_a_truck.end(), {2.4F, 2.45F, 2.5F});
  EXPECT_EQ(ground_heights(under_a_truck).size(), 1U) << "the upper one";
}

TEST(GroundHeights, AreRobustAgainstMovingObjectsAndOutliers) {
  EXPECT_EQ(ground_heights({0.0F, 0.01F, 0.02F, 0.8F, 1.4F}), std::vector<float>{0.02F});
  EXPECT_EQ(ground_heights({-5.0F, 0.0F, 0.01F, 0.02F}), std::vector<float>{0.02F});
}

/// Grounds of columns, as ground_cells() sorts them.
class Cells {
 public:
  /// A rectangle of cells; `slope` is the rise from one column to the next, m.
  void add(int column, int row, int columns, int rows, double height, double slope = 0.0) {
    for (int i = 0; i < columns; ++i) {
      for (int k = 0; k < rows; ++k) cells_.push_back({column + i, row + k, height + slope * i});
    }
  }
  void remove(int column, int row, int columns, int rows, double height) {
    const auto is_inside = [&](const GroundCell& cell) {
      return cell.column >= column && cell.column < column + columns && cell.row >= row &&
             cell.row < row + rows && std::abs(cell.height - height) < 0.01;
    };
    cells_.erase(std::remove_if(cells_.begin(), cells_.end(), is_inside), cells_.end());
  }
  std::vector<OpenCell> open() {
    std::sort(cells_.begin(), cells_.end(), [](const GroundCell& a, const GroundCell& b) {
      return std::tie(a.column, a.row, a.height) < std::tie(b.column, b.row, b.height);
    });
    return find_open_ground(cells_);
  }

 private:
  std::vector<GroundCell> cells_;
};

/// Number of open cells between two heights, m.
std::ptrdiff_t between(const std::vector<OpenCell>& open, double low, double high) {
  return std::count_if(open.begin(), open.end(), [&](const OpenCell& cell) {
    return cell.p_map.z() > low && cell.p_map.z() < high;
  });
}

TEST(OpenGround, IsTheInsideOfAFlatStreet) {
  Cells street;
  street.add(-3, 5, 20, 10, 1.5);
  const std::vector<OpenCell> open = street.open();
  ASSERT_EQ(open.size(), 18U * 8U);
  EXPECT_TRUE(near(open.front().p_map, Eigen::Vector3d(-1.5, 6.5, 1.5), 1e-9));
  EXPECT_TRUE(near(open.front().up, Eigen::Vector3d::UnitZ(), 1e-6));
  EXPECT_EQ(open.front().clearance, 1);
  const auto middle = std::max_element(
      open.begin(), open.end(),
      [](const OpenCell& a, const OpenCell& b) { return a.clearance < b.clearance; });
  EXPECT_EQ(middle->clearance, 4) << "of eight rows";
}

TEST(OpenGround, HasTheNormalOfARamp) {
  Cells ramp;
  ramp.add(0, 0, 20, 10, 0.0, 0.1);
  const std::vector<OpenCell> open = ramp.open();
  ASSERT_FALSE(open.empty());
  for (const OpenCell& cell : open) {
    EXPECT_TRUE(near(cell.up, Eigen::Vector3d(-0.1, 0.0, 1.0).normalized(), 1e-6));
  }
}

TEST(OpenGround, IsNotOnWallsCarsAndPatches) {
  Cells street;
  street.add(0, 0, 60, 10, 0.0);
  street.add(0, 10, 60, 2, 3.0);  // the top of a wall
  street.remove(20, 4, 5, 2, 0.0);
  street.add(20, 4, 5, 2, 1.5);   // the roof of a car
  street.add(100, 0, 7, 7, 0.0);  // a patch somewhere, 25 cells of which are surrounded
  const std::vector<OpenCell> open = street.open();
  EXPECT_EQ(between(open, 0.5, 4.0), 0);
  EXPECT_GT(between(open, -0.1, 0.1), 300);
  for (const OpenCell& cell : open) {
    EXPECT_LT(cell.p_map.x(), 60.0);
    const bool is_beside_the_car = cell.p_map.x() > 20.0 && cell.p_map.x() < 25.0 &&
                                   cell.p_map.y() > 3.0 && cell.p_map.y() < 7.0;
    EXPECT_FALSE(is_beside_the_car) << cell.p_map.transpose();
  }
}

TEST(OpenGround, IsOnStoreysThatARampConnects) {
  Cells car_park;
  car_park.add(0, 0, 20, 10, 0.0);
  car_park.add(20, 0, 20, 5, 0.15, 0.15);  // the ramp, up to 3 m
  car_park.add(40, 0, 6, 10, 3.0);
  car_park.add(0, 5, 40, 5, 3.0);  // back
  car_park.add(0, 0, 20, 5, 3.0);
  const std::vector<OpenCell> open = car_park.open();
  EXPECT_GT(between(open, -0.1, 0.1), 100);
  EXPECT_GT(between(open, 2.9, 3.1), 200);
}

TEST(OpenGround, IsNotOnACeiling) {
  Cells car_park;
  car_park.add(0, 0, 30, 10, 0.0);
  car_park.add(0, 0, 20, 10, 3.0);
  const std::vector<OpenCell> open = car_park.open();
  EXPECT_EQ(between(open, 2.9, 3.1), 0);
  EXPECT_EQ(between(open, -0.1, 0.1), 28 * 8);
}

TEST(GroundCells, AreFoundInTilesOnBothSidesOfZero) {
  test::MadeMap map;
  map.add_rectangle({-50.1, -3.1, 7.0}, {100.0, 0.0, 0.0}, {0.0, 6.0, 0.0});
  const test::TemporaryFolder folder;
  PointTiles tiles(folder.path(), 0.2);
  tiles.add(map.points);
  tiles.finish();
  const std::vector<GroundCell> cells = ground_cells(tiles);
  ASSERT_FALSE(cells.empty());
  EXPECT_EQ(cells.front().column, -51);
  EXPECT_EQ(cells.back().column, 49);
  for (const GroundCell& cell : cells) {
    EXPECT_NEAR(cell.height, 7.0, 1e-5);
    EXPECT_GE(cell.row, -4);
    EXPECT_LE(cell.row, 2);
  }
  EXPECT_GE(find_open_ground(cells).size(), 98U * 4U);
}

}  // namespace
}  // namespace lidar_mapping::map_import
