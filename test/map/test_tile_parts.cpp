// SPDX-License-Identifier: BSD-3-Clause
// Tiles, voxels of a tile, and the frame of the grid.

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "grid/grid_frame.hpp"
#include "near.hpp"
#include "tiles/voxel_tile.hpp"

namespace lidar_mapping::map {
namespace {

TEST(TileGrid, DividesThePlaneOnBothSidesOfZero) {
  const TileGrid grid(0.5, 20.0);
  const auto tile_of = [&](double x, double y) {
    return grid.square_of(grid.voxel_of({x, y, 0.0})).tile;
  };
  EXPECT_EQ(tile_of(0.0, 0.0), (TileIndex{0, 0}));
  EXPECT_EQ(tile_of(19.9, 20.0), (TileIndex{0, 1}));
  EXPECT_EQ(tile_of(-0.1, -20.0), (TileIndex{-1, -1}));
  EXPECT_EQ(tile_of(-20.1, -40.1), (TileIndex{-2, -3}));
  EXPECT_EQ(tile_of(1e7, -1e7), (TileIndex{500'000, -500'000}));
}

TEST(TileGrid, HasSquaresWithTheirOrigin) {
  const TileGrid grid(0.5, 20.0);
  const TileGrid::Square square = grid.square_of(grid.voxel_of({-30.0, 50.0, 3.0}));
  EXPECT_TRUE(test::near(square.origin, Eigen::Vector3d(-40.0, 40.0, 0.0), 1e-12));
  EXPECT_TRUE(square.contains(grid.voxel_of({-40.0, 40.0, -100.0})));
  EXPECT_TRUE(square.contains(grid.voxel_of({-20.1, 59.9, 100.0})));
  EXPECT_FALSE(square.contains(grid.voxel_of({-19.9, 50.0, 0.0})));
  EXPECT_FALSE(square.contains(grid.voxel_of({-40.1, 50.0, 0.0})));
  EXPECT_FALSE(square.contains(grid.voxel_of({-30.0, 39.9, 0.0})));
  EXPECT_FALSE(TileGrid::Square().contains(grid.voxel_of({0.0, 0.0, 0.0})));
}

// 7.3 m are no whole number of voxels: the border of a tile would cut some in two.
TEST(TileGrid, HasTilesOfWholeVoxels) {
  const TileGrid grid(0.4, 7.3);
  const auto origin = [&](double x) {
    return grid.square_of(grid.voxel_of({x, 0.0, 0.0})).origin.x();
  };
  EXPECT_NEAR(origin(7.0), 0.0, 1e-12);
  EXPECT_NEAR(origin(7.21), 7.2, 1e-12) << "18 voxels";
  const TileGrid small(0.4, 0.1);
  EXPECT_NEAR(small.square_of(small.voxel_of({0.9, 0.0, 0.0})).origin.x(), 0.8, 1e-12)
      << "at least one voxel";
}

TEST(TileGrid, GivesEachVoxelOfATileItsOwnKey) {
  const TileGrid grid(0.5, 20.0);
  const TileGrid::Square square = grid.square_of(grid.voxel_of({-30.0, 50.0, 0.0}));
  const auto key = [&](double x, double y, double z) {
    return square.key_of(grid.voxel_of({x, y, z}));
  };
  EXPECT_EQ(key(-30.0, 50.0, 1.0), key(-29.6, 50.4, 1.4));
  EXPECT_NE(key(-30.0, 50.0, 1.0), key(-29.4, 50.0, 1.0));
  EXPECT_NE(key(-30.0, 50.0, 1.0), key(-30.0, 50.6, 1.0));
  EXPECT_NE(key(-30.0, 50.0, 0.1), key(-30.0, 50.0, -0.1));
  EXPECT_NE(key(-29.0, 50.0, 1.0), key(-30.0, 51.0, 1.0)) << "x and y are not exchanged";
}

TilePoint point_in(std::uint64_t voxel, float x, float intensity = 0.0F) {
  return {voxel, {x, 2.0F * x, -x, intensity}};
}

TEST(VoxelTile, HasTheMeanOfEachVoxelInTheOrderOfFirstPoints) {
  VoxelTile tile;
  tile.insert({point_in(9, 1.0F, 10.0F), point_in(4, 5.0F, 7.0F), point_in(9, 2.0F, 30.0F)}, 3);
  tile.insert({point_in(4, 7.0F, 9.0F), point_in(2, 0.0F)}, 4);
  ASSERT_EQ(tile.size(), 3U);
  PointCloud cloud;
  cloud.points.push_back({});
  tile.append_to(cloud, {100.0, 200.0, 300.0});
  ASSERT_EQ(cloud.size(), 4U) << "behind what was there";
  EXPECT_EQ(cloud.points[1].position(), Eigen::Vector3f(101.5F, 203.0F, 298.5F));
  EXPECT_EQ(cloud.points[1].intensity, 20.0F);
  EXPECT_EQ(cloud.points[2].position(), Eigen::Vector3f(106.0F, 212.0F, 294.0F));
  EXPECT_EQ(cloud.points[2].intensity, 8.0F);
  EXPECT_EQ(tile.key_frames(), (std::vector<KeyFrameIndex>{3, 3, 4})) << "the first that saw it";
}

// Its table grows several times, and keys that differ in their upper bits alone meet in it.
TEST(VoxelTile, FindsItsVoxelsWhileItGrows) {
  VoxelTile tile;
  std::vector<TilePoint> points;
  for (std::uint64_t i = 0; i < 20'000; ++i) points.push_back(point_in(i << 32U | i % 7U, 1.0F));
  for (int round = 0; round < 3; ++round) tile.insert(points, 1);
  ASSERT_EQ(tile.size(), 20'000U);
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    ASSERT_EQ(tile.voxels()[i].key, i << 32U | i % 7U);
    ASSERT_EQ(tile.voxels()[i].count, 3U);
  }
}

TEST(VoxelTile, GoesOnAfterItWasRestored) {
  std::mt19937 engine(2);
  std::vector<TilePoint> points;
  for (int i = 0; i < 5000; ++i) {
    points.push_back(point_in(engine() % 3000, static_cast<float>(engine() % 100)));
  }
  VoxelTile whole;
  whole.insert(points, 1);
  whole.insert(points, 1);
  VoxelTile half;
  half.insert(points, 1);
  VoxelTile restored(half.voxels());
  restored.insert(points, 1);
  ASSERT_EQ(restored.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    ASSERT_EQ(restored.voxels()[i].key, whole.voxels()[i].key) << i;
    ASSERT_EQ(restored.voxels()[i].x, whole.voxels()[i].x) << i;
    ASSERT_EQ(restored.voxels()[i].count, whole.voxels()[i].count) << i;
  }
}

PointCloud cloud_of(const std::vector<Eigen::Vector2f>& positions) {
  PointCloud cloud;
  for (const Eigen::Vector2f& p : positions) cloud.points.push_back({p.x(), p.y(), 0.0F, 0.0F});
  return cloud;
}

TEST(GridFrame, IsTheSmallestAroundAllPoints) {
  const PointCloud cloud = cloud_of({{-1.3F, 2.1F}, {3.2F, 7.9F}});
  const GridFrame frame(cloud, 0.5);
  EXPECT_EQ(frame.x_min, -1.5);
  EXPECT_EQ(frame.y_min, 2.0);
  EXPECT_EQ(frame.columns, 10) << "from -1.5 to 3.5 m";
  EXPECT_EQ(frame.rows, 12) << "from 2 to 8 m";
  EXPECT_EQ(frame.column_of(-1.3F), 0);
  EXPECT_EQ(frame.column_of(3.2F), 9);
  EXPECT_EQ(frame.row_of(7.9F), 11);
  EXPECT_EQ(frame.x_of(0.5), -1.25) << "the middle of the first column";
  EXPECT_EQ(frame.y_of(12.0), 8.0);
}

TEST(GridFrame, HasOneCellForOnePoint) {
  const PointCloud cloud = cloud_of({{-0.1F, 0.1F}});
  const GridFrame frame(cloud, 0.5);
  EXPECT_EQ(frame.columns, 1);
  EXPECT_EQ(frame.rows, 1);
  EXPECT_EQ(frame.x_min, -0.5);
  EXPECT_THROW(GridFrame(PointCloud(), 0.5), InputError);
}

TEST(GridFrame, DescribesItselfToMapServer) {
  const PointCloud cloud = cloud_of({{-1.3F, 2.1F}});
  const std::string yaml = GridFrame(cloud, 0.25).yaml();
  EXPECT_NE(yaml.find("resolution: 0.25\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("origin: [-1.500000, 2.000000, 0.0]\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("image: grid.pgm\n"), std::string::npos) << yaml;
}

TEST(GridBlock, NumbersItsCellsRowByRow) {
  const GridBlock block{10, 20, 3, 2};
  EXPECT_EQ(block.size(), 6U);
  EXPECT_TRUE(block.contains(10, 20));
  EXPECT_TRUE(block.contains(12, 21));
  EXPECT_FALSE(block.contains(13, 20));
  EXPECT_FALSE(block.contains(10, 22));
  EXPECT_FALSE(block.contains(9, 20));
  EXPECT_FALSE(block.contains(10, 19));
  EXPECT_EQ(block.index_of(10, 20), 0U);
  EXPECT_EQ(block.index_of(12, 20), 2U);
  EXPECT_EQ(block.index_of(10, 21), 3U);
}

}  // namespace
}  // namespace lidar_mapping::map
