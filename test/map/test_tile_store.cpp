// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "memory_clouds.hpp"
#include "near.hpp"
#include "tiles/tile_store.hpp"

namespace lidar_mapping::map {
namespace {

constexpr double kResolution = 0.5;
constexpr double kTileSize = 10.0;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Clouds along a street that crosses several tiles, on both sides of zero.
std::vector<CloudWithPose> street() {
  std::mt19937 engine(6);
  std::uniform_real_distribution<float> along(-8.0F, 8.0F), across(-6.0F, 6.0F);
  std::vector<CloudWithPose> clouds;
  for (KeyFrameIndex index = 0; index < 12; ++index) {
    auto cloud = std::make_shared<PointCloud>();
    for (int i = 0; i < 400; ++i) {
      const float x = along(engine), y = across(engine), z = 0.2F * across(engine);
      cloud->points.push_back({x, y, z, static_cast<float>(i)});
    }
    cloud->points.push_back({kNaN, 0.0F, 0.0F, 1.0F});
    cloud->points.push_back({0.0F, 0.0F, std::numeric_limits<float>::infinity(), 1.0F});
    Pose pose{exp_so3({0.0, 0.02, 0.3 * index}), {3.0 * index - 18.0, 0.7 * index, 0.1 * index}};
    clouds.push_back({index, cloud, pose});
  }
  return clouds;
}

std::set<TileIndex> all_tiles(const std::vector<std::vector<TileIndex>>& touched) {
  std::set<TileIndex> tiles;
  for (const auto& of_cloud : touched) tiles.insert(of_cloud.begin(), of_cloud.end());
  return tiles;
}

TEST(TileStore, HasTheMeanOfThePointsOfEachVoxel) {
  struct Sum {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    double intensity = 0.0;
    int count = 0;
  };
  std::map<std::tuple<int, int, int>, Sum> voxels;
  const std::vector<CloudWithPose> clouds = street();
  for (const CloudWithPose& cloud : clouds) {
    for (const Point& point : cloud.cloud->points) {
      if (!point.position().allFinite()) continue;
      const Eigen::Vector3d p = cloud.T_map_base * point.position().cast<double>();
      const Eigen::Vector3i cell = (p / kResolution).array().floor().matrix().cast<int>();
      Sum& sum = voxels[{cell.x(), cell.y(), cell.z()}];
      sum.position += p;
      sum.intensity += static_cast<double>(point.intensity);
      ++sum.count;
    }
  }
  TileStore store(kResolution, kTileSize, 1);
  store.add(clouds, nullptr);
  const PointCloud map = store.merged_cloud();
  ASSERT_EQ(map.size(), voxels.size());
  for (const Point& point : map.points) {
    const Eigen::Vector3d p = point.position().cast<double>();
    const Eigen::Vector3i cell = (p / kResolution).array().floor().matrix().cast<int>();
    const auto found = voxels.find({cell.x(), cell.y(), cell.z()});
    ASSERT_NE(found, voxels.end()) << p.transpose();
    EXPECT_TRUE(test::near(p, found->second.position / found->second.count, 1e-4));
    EXPECT_NEAR(point.intensity, found->second.intensity / found->second.count, 1e-3);
  }
}

TEST(TileStore, DependsNeitherOnBatchesNorOnThreads) {
  const std::vector<CloudWithPose> clouds = street();
  TileStore at_once(kResolution, kTileSize, 1);
  at_once.add(clouds, nullptr);
  const PointCloud expected = at_once.merged_cloud();
  for (const std::size_t batch : {1U, 5U, 12U}) {
    TileStore store(kResolution, kTileSize, 3);
    for (std::size_t begin = 0; begin < clouds.size(); begin += batch) {
      const std::size_t end = std::min(begin + batch, clouds.size());
      store.add({clouds.begin() + static_cast<std::ptrdiff_t>(begin),
                 clouds.begin() + static_cast<std::ptrdiff_t>(end)},
                nullptr);
    }
    expect_same_bits(store.merged_cloud(), expected);
  }
}

TEST(TileStore, ListsTheTilesThatEachCloudTouches) {
  const std::vector<CloudWithPose> clouds = street();
  TileStore store(kResolution, kTileSize, 2);
  const auto touched = store.add(clouds, nullptr);
  ASSERT_EQ(touched.size(), clouds.size());
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    EXPECT_EQ(touched[i], store.tiles_of(clouds[i])) << i;
    std::set<std::pair<double, double>> expected;
    for (const Point& point : clouds[i].cloud->points) {
      if (!point.position().allFinite()) continue;
      const Eigen::Vector3d p = clouds[i].T_map_base * point.position().cast<double>();
      expected.insert({std::floor(p.x() / kTileSize), std::floor(p.y() / kTileSize)});
    }
    EXPECT_EQ(touched[i].size(), expected.size()) << i;
  }
  for (const TileIndex& tile : all_tiles(touched)) EXPECT_TRUE(store.contains(tile));
}

// A large map is built in portions of tiles, each time from all clouds.
TEST(TileStore, IsTheSameInPortionsOfTiles) {
  const std::vector<CloudWithPose> clouds = street();
  TileStore whole(kResolution, kTileSize, 1);
  const std::set<TileIndex> tiles = all_tiles(whole.add(clouds, nullptr));
  ASSERT_GT(tiles.size(), 6U);
  TileStore portions(kResolution, kTileSize, 1);
  for (const TileIndex& tile : tiles) {
    const std::set<TileIndex> only = {tile};
    EXPECT_EQ(all_tiles(portions.add(clouds, &only)), only);
  }
  expect_same_bits(portions.merged_cloud(), whole.merged_cloud());
}

TEST(TileStore, DoesNothingWithoutATileToTake) {
  TileStore store(kResolution, kTileSize, 1);
  const std::set<TileIndex> none, elsewhere = {{900, 900}};
  EXPECT_TRUE(all_tiles(store.add(street(), &none)).empty());
  EXPECT_TRUE(all_tiles(store.add(street(), &elsewhere)).empty());
  EXPECT_TRUE(store.add({}, nullptr).empty());
  EXPECT_EQ(store.merged_cloud().size(), 0U);
  EXPECT_FALSE(store.contains({900, 900}));
}

TEST(TileStore, GivesATileRelativeToItsCorner) {
  TileStore store(kResolution, kTileSize, 1);
  store.add({{42, cloud_of({{12.1F, -3.9F, 7.1F, 5.0F}}), Pose()}}, nullptr);
  const MapTile tile = store.tile({1, -1});
  EXPECT_TRUE(test::near(tile.origin, Eigen::Vector3d(10.0, -10.0, 0.0), 1e-12));
  ASSERT_EQ(tile.cloud.size(), 1U);
  EXPECT_TRUE(test::near(tile.cloud.points[0].position(), Eigen::Vector3f(2.1F, 6.1F, 7.1F), 1e-5));
  EXPECT_EQ(tile.key_frames, std::vector<KeyFrameIndex>{42});
  const MapTile missing = store.tile({5, 5});
  EXPECT_EQ(missing.cloud.size(), 0U);
  EXPECT_TRUE(test::near(missing.origin, Eigen::Vector3d(50.0, 50.0, 0.0), 1e-12));
}

// 100 km from the origin, where a float has steps of 8 mm.
TEST(TileStore, LosesNoPrecisionFarFromTheOrigin) {
  Pose far;
  far.translation = {100'000.0, -200'000.0, 0.0};
  TileStore store(kResolution, kTileSize, 1);
  const auto touched = store.add({{0, cloud_of({{1.234F, 2.345F, 0.123F, 0.0F}}), far}}, nullptr);
  ASSERT_EQ(touched[0].size(), 1U);
  const MapTile tile = store.tile(touched[0][0]);
  const Eigen::Vector3d p = tile.origin + tile.cloud.points[0].position().cast<double>();
  EXPECT_TRUE(test::near(p, Eigen::Vector3d(100'001.234, -199'997.655, 0.123), 1e-5));
}

TEST(TileStore, GivesTilesAwayAndTakesThemBack) {
  TileStore store(kResolution, kTileSize, 1);
  const std::vector<CloudWithPose> clouds = street();
  const std::set<TileIndex> tiles = all_tiles(store.add(clouds, nullptr));
  const PointCloud before = store.merged_cloud();
  const TileIndex first = *tiles.begin();
  const std::size_t voxels = store.voxels(first);
  VoxelTile tile = store.extract(first);
  EXPECT_FALSE(store.contains(first));
  EXPECT_EQ(tile.size(), voxels);
  EXPECT_EQ(store.merged_cloud().size(), before.size() - voxels);
  store.put(first, std::move(tile));
  expect_same_bits(store.merged_cloud(), before);
}

TEST(TileStore, DiscardsTilesAndBuildsThemAgain) {
  TileStore store(kResolution, kTileSize, 1);
  const std::vector<CloudWithPose> clouds = street();
  const std::set<TileIndex> tiles = all_tiles(store.add(clouds, nullptr));
  const PointCloud before = store.merged_cloud();
  const std::set<TileIndex> some = {*tiles.begin(), *tiles.rbegin(), {900, 900}};
  store.clear(some);
  for (const TileIndex& tile : tiles) EXPECT_EQ(store.contains(tile), some.count(tile) == 0);
  store.add(clouds, &some);
  expect_same_bits(store.merged_cloud(), before);
  store.clear();
  EXPECT_EQ(store.merged_cloud().size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::map
