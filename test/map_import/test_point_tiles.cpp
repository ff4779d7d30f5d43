// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "near.hpp"
#include "point_tiles.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map_import {
namespace {

using test::near;
using test::TemporaryFolder;

/// Points on a line along x, a metre apart.
std::vector<MapPoint> line(double first, int count, double y, double z) {
  std::vector<MapPoint> points;
  for (int i = 0; i < count; ++i) points.push_back({{first + i, y, z}, 3.0F});
  return points;
}

TEST(PointTiles, GiveAllPointsBackSquareBySquare) {
  const TemporaryFolder folder;
  PointTiles tiles(folder.path(), 0.2);
  tiles.add(line(-59.5, 120, 10.0, 2.0));
  EXPECT_TRUE(tiles.indices().empty()) << "before they are thinned";
  tiles.finish();
  EXPECT_EQ(tiles.points(), 120U);
  EXPECT_EQ(tiles.thinned(), 120U);
  ASSERT_EQ(tiles.indices().size(), 4U);
  double x = -59.5;
  for (const PointTileIndex& index : tiles.indices()) {
    const PointTilePtr tile = tiles.tile(index);
    for (const Point& point : tile->cloud.points) {
      const Eigen::Vector3d p = tile->origin + point.position().cast<double>();
      EXPECT_TRUE(near(p, Eigen::Vector3d(x, 10.0, 2.0), 1e-5));
      EXPECT_EQ(point.intensity, 3.0F);
      x += 1.0;
    }
  }
  EXPECT_EQ(x, 60.5);
}

TEST(PointTiles, ThinPointsToTheirMean) {
  const TemporaryFolder folder;
  PointTiles tiles(folder.path(), 0.2);
  tiles.add({{{5.02, 5.02, 0.0}, 1.0F}, {{5.06, 5.1, 0.0}, 2.0F}, {{5.3, 5.1, 0.0}, 5.0F}});
  tiles.finish();
  EXPECT_EQ(tiles.points(), 3U);
  ASSERT_EQ(tiles.thinned(), 2U);
  const Point& mean = tiles.tile(tiles.indices().front())->cloud.points.front();
  EXPECT_NEAR(mean.x, 5.04, 1e-5);
  EXPECT_NEAR(mean.y, 5.06, 1e-5);
  EXPECT_NEAR(mean.intensity, 1.5, 1e-6);
}

TEST(PointTiles, KeepMillimetresFarFromTheOrigin) {
  const TemporaryFolder folder;
  PointTiles tiles(folder.path(), 0.2);
  const Eigen::Vector3d utm(456789.123, 5428765.432, 4321.987);
  tiles.add({{utm, 0.0F}});
  tiles.finish();
  const PointTilePtr tile = tiles.tile(tiles.indices().front());
  const Eigen::Vector3d p = tile->origin + tile->cloud.points.front().position().cast<double>();
  EXPECT_TRUE(near(p, utm, 1e-4));
  EXPECT_TRUE(near(tiles.bounds().min(), utm, 1e-9));
}

TEST(PointTiles, AreFoundAroundAPosition) {
  const TemporaryFolder folder;
  PointTiles tiles(folder.path(), 0.2);
  tiles.add(line(-200.0, 400, 10.0, 0.0));
  tiles.add(line(-200.0, 400, 210.0, 0.0));
  tiles.finish();
  const auto near_zero = tiles.indices_around({1.0, 1.0, 0.0}, 80.0);
  ASSERT_EQ(near_zero.size(), 5U) << "from -79 to 81";
  EXPECT_EQ(near_zero.front().column, -2);
  for (const PointTileIndex& index : near_zero) EXPECT_EQ(index.row, 0);
  EXPECT_TRUE(tiles.indices_around({1.0, -200.0, 0.0}, 80.0).empty());
}

// More points than the cache holds at once, and more than the buffer of a square.
TEST(PointTiles, AreReadAgainWhenTheCacheIsFull) {
  const TemporaryFolder folder;
  constexpr int kPerTile = 5000;
  PointTiles tiles(folder.path(), 0.0, 3 * kPerTile);
  std::vector<MapPoint> points(kPerTile);
  for (int column = 0; column < 7; ++column) {
    for (MapPoint& point : points) point.p_map = {40.0 * column + 1.0, 1.0, 1.0 * column};
    tiles.add(points);
  }
  tiles.finish();
  EXPECT_EQ(tiles.thinned(), 7U * kPerTile);
  const PointTilePtr first = tiles.tile(tiles.indices().front());
  for (const PointTileIndex& index : tiles.indices()) {
    const PointTilePtr tile = tiles.tile(index);
    ASSERT_EQ(tile->cloud.size(), static_cast<std::size_t>(kPerTile));
    EXPECT_EQ(tile->cloud.points.back().z, static_cast<float>(index.column));
  }
  EXPECT_NE(tiles.tile(tiles.indices().front()), first) << "it was read again";
  EXPECT_EQ(tiles.tile(tiles.indices().front()), tiles.tile(tiles.indices().front()));
}

}  // namespace
}  // namespace lidar_mapping::map_import
