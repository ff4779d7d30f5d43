// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/map/map_builder.hpp"

#include "memory_clouds.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

PointCloudPtr random_cloud(std::mt19937& random, int points) {
  std::uniform_real_distribution<float> xy(-40.0F, 40.0F);
  std::uniform_real_distribution<float> z(-2.0F, 8.0F);
  std::vector<Point> cloud;
  for (int i = 0; i < points; ++i) cloud.push_back({xy(random), xy(random), z(random), z(random)});
  return cloud_of(std::move(cloud));
}

/// A drive along x with `key_frames` clouds, 5 m apart.
struct Drive {
  MemoryClouds clouds;
  KeyFramePoses poses;

  explicit Drive(KeyFrameIndex key_frames, int points = 500) {
    std::mt19937 random(3);
    for (KeyFrameIndex index = 0; index < key_frames; ++index) {
      clouds.clouds[index] = random_cloud(random, points);
      Pose pose;
      pose.translation = {5.0 * index, 0.0, 0.0};
      poses.poses.push_back({index, Stamp{index}, pose});
    }
  }

  void move(KeyFrameIndex index, const Eigen::Vector3d& by) {
    poses.poses[index].T_map_base.translation += by;
  }
};

MapConfig exact_config() {
  MapConfig config;
  config.resolution = 0.5;
  config.tile_size = 20.0;
  config.rebuild_distance = 0.0;
  return config;
}

// Centroid and mean intensity, not the centre of the cell.
TEST(MapBuilder, ComputesCentroidAndMeanIntensityOfEachVoxel) {
  MemoryClouds clouds;
  clouds.clouds[0] = cloud_of({{0.1F, 0.1F, 0.1F, 10.0F}, {0.3F, 0.2F, 0.1F, 20.0F}});
  clouds.clouds[1] = cloud_of({{0.2F, 0.3F, 0.4F, 30.0F}, {-0.1F, 0.1F, 0.1F, 7.0F}});
  KeyFramePoses poses;
  poses.poses = {{0, 0, Pose()}, {1, 1, Pose()}};
  const PointCloud map = build_map(poses, clouds, exact_config());
  ASSERT_EQ(map.size(), 2U);
  const auto centroid = std::max_element(map.points.begin(), map.points.end(),
                                         [](const auto& a, const auto& b) { return a.x < b.x; });
  EXPECT_NEAR(centroid->x, 0.2, 1e-6);
  EXPECT_NEAR(centroid->y, 0.2, 1e-6);
  EXPECT_NEAR(centroid->z, 0.2, 1e-6);
  EXPECT_NEAR(centroid->intensity, 20.0, 1e-6);
}

// An inclined plane stays plane: its RMS error is below a tenth of the voxel.
TEST(MapBuilder, KeepsInclinedPlanesPlane) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-5.0F, 5.0F);
  std::vector<Point> points;
  for (int i = 0; i < 200'000; ++i) {
    const float x = uniform(random);
    const float y = uniform(random);
    points.push_back({x, y, 0.4F * x + 0.2F * y, 0.0F});
  }
  MemoryClouds clouds;
  clouds.clouds[0] = cloud_of(points);
  KeyFramePoses poses;
  poses.poses = {{0, 0, Pose()}};
  double squares = 0.0;
  const PointCloud map = build_map(poses, clouds, exact_config());
  for (const Point& point : map.points) {
    const double distance = static_cast<double>(point.z - 0.4F * point.x - 0.2F * point.y);
    squares += distance * distance;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(map.size())), 0.05);
}

TEST(MapBuilder, LeavesOutPointsThatAreNotFinite) {
  MemoryClouds clouds;
  clouds.clouds[0] =
      cloud_of({{NAN, 0.0F, 0.0F, 0.0F}, {1.0F, 1.0F, INFINITY, 0.0F}, {1.0F, 2.0F, 3.0F, 4.0F}});
  KeyFramePoses poses;
  poses.poses = {{0, 0, Pose()}};
  EXPECT_EQ(build_map(poses, clouds, exact_config()).size(), 1U);
}

// After any sequence of moved, added and removed key frames the map is that of the poses.
TEST(MapBuilder, PartialUpdatesEqualFullRebuildBitForBit) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  Drive drive(30);
  KeyFramePoses known;
  MapBuilder builder(exact_config(), drive.clouds);
  for (KeyFrameIndex index = 0; index < 30; ++index) {
    known.poses.push_back(drive.poses.poses[index]);
    if (index % 4 == 3)
      known.poses[random() % known.poses.size()].T_map_base.translation.x() += normal(random);
    if (index == 17) known.poses.erase(known.poses.begin() + 4);
    builder.update(known);
    expect_same_bits(builder.build(), build_map(known, drive.clouds, exact_config()));
  }
}

TEST(MapBuilder, AcceptsPartialPoses) {
  Drive drive(10);
  MapBuilder builder(exact_config(), drive.clouds);
  builder.update(drive.poses);
  builder.build();
  drive.move(4, {1.0, 0.5, 0.0});
  KeyFramePoses part;
  part.whole = false;
  part.poses = {drive.poses.poses[4]};
  builder.update(part);
  expect_same_bits(builder.build(), build_map(drive.poses, drive.clouds, exact_config()));
}

// Only key frames near the moved one are inserted again.
TEST(MapBuilder, ReinsertsOnlyNeighboursOfMovedKeyFrame) {
  Drive drive(200);
  MapBuilder builder(exact_config(), drive.clouds);
  builder.update(drive.poses);
  builder.build();
  const std::size_t before = drive.clouds.reads;
  EXPECT_EQ(before, 200U);
  drive.move(100, {0.3, 0.0, 0.0});
  builder.update(drive.poses);
  builder.build();
  EXPECT_LT(drive.clouds.reads - before, 60U);
}

// Without changes nothing is rebuilt.
TEST(MapBuilder, UnchangedPosesRebuildNothing) {
  Drive drive(10);
  MapBuilder builder(exact_config(), drive.clouds);
  builder.update(drive.poses);
  builder.build();
  const std::uint64_t revision = builder.revision();
  const std::size_t reads = drive.clouds.reads;
  builder.update(drive.poses);
  EXPECT_EQ(builder.revision(), revision);
  builder.build();
  EXPECT_EQ(drive.clouds.reads, reads);
}

TEST(MapBuilder, MotionsBelowThresholdAccumulate) {
  Drive drive(10);
  MapConfig config = exact_config();
  config.rebuild_distance = 0.05;
  MapBuilder builder(config, drive.clouds);
  builder.update(drive.poses);
  builder.build();
  const std::uint64_t revision = builder.revision();
  drive.move(9, {0.03, 0.0, 0.0});
  builder.update(drive.poses);
  EXPECT_EQ(builder.revision(), revision);
  drive.move(9, {0.03, 0.0, 0.0});
  builder.update(drive.poses);
  EXPECT_GT(builder.revision(), revision);
  expect_same_bits(builder.build(), build_map(drive.poses, drive.clouds, config));
}

TEST(MapBuilder, RequestsMissingCloudsAgain) {
  Drive drive(10);
  const PointCloudPtr late = drive.clouds.clouds[4];
  drive.clouds.clouds.erase(4);
  MapBuilder builder(exact_config(), drive.clouds);
  builder.update(drive.poses);
  builder.build();
  EXPECT_EQ(builder.missing_clouds(), 1U);
  drive.clouds.clouds[4] = late;
  expect_same_bits(builder.build(), build_map(drive.poses, drive.clouds, exact_config()));
  EXPECT_EQ(builder.missing_clouds(), 0U);
}

// The points of the last key frame are still in the tiles that are not rebuilt without its cloud.
TEST(MapBuilder, AddsNoPointTwiceAfterACloudWasMissing) {
  Drive drive(10, 5000);
  MapBuilder builder(exact_config(), drive.clouds);
  builder.update(drive.poses);
  builder.build();
  const PointCloudPtr last = drive.clouds.clouds[9];
  drive.clouds.clouds.erase(9);
  drive.move(0, {-0.3, 0.0, 0.0});
  builder.update(drive.poses);
  builder.build();
  EXPECT_EQ(builder.missing_clouds(), 1U);
  drive.clouds.clouds[9] = last;
  expect_same_bits(builder.build(), build_map(drive.poses, drive.clouds, exact_config()));
  EXPECT_EQ(builder.missing_clouds(), 0U);
}

TEST(MapBuilder, DoesNotDependOnTheNumberOfThreads) {
  Drive drive(20);
  MapConfig config = exact_config();
  config.threads = 1;
  const PointCloud one = build_map(drive.poses, drive.clouds, config);
  for (const int threads : {2, 4}) {
    config.threads = threads;
    expect_same_bits(build_map(drive.poses, drive.clouds, config), one);
  }
}

TEST(MapBuilder, HasFewerPointsWithLargerVoxels) {
  Drive drive(10);
  MapConfig coarse = exact_config();
  coarse.resolution = 2.0;
  EXPECT_LT(build_map(drive.poses, drive.clouds, coarse).size(),
            build_map(drive.poses, drive.clouds, exact_config()).size());
}

/// Points of all tiles, in the order of the tiles.
PointCloud merged_tiles(Drive& drive) {
  const test::TemporaryFolder folder;
  PointCloud merged;
  std::set<TileIndex> known;
  build_tiles(drive.poses, drive.clouds, exact_config(), folder.path(), [&](const MapTile& tile) {
    EXPECT_TRUE(known.insert(tile.index).second) << "a tile comes once";
    for (Point point : tile.cloud.points) {
      EXPECT_GE(point.x, -1e-4F);
      EXPECT_LE(point.x, 20.0001F);
      point.x += static_cast<float>(tile.origin.x());
      point.y += static_cast<float>(tile.origin.y());
      merged.points.push_back(point);
    }
  });
  return merged;
}

void expect_tiles_of_map(Drive& drive) {
  const PointCloud merged = merged_tiles(drive);
  const PointCloud map = build_map(drive.poses, drive.clouds, exact_config());
  ASSERT_EQ(merged.size(), map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    ASSERT_TRUE(test::near(merged.points[i].position(), map.points[i].position(), 2e-4F));
  }
}

TEST(BuildTiles, MergedTilesAreTheMap) {
  Drive drive(100);
  expect_tiles_of_map(drive);
}

// A drive there and back that is so long that tiles are stored on the disk in between.
TEST(BuildTiles, TilesStoredOnDiskAreRestored) {
  Drive drive(600, 2000);
  for (KeyFrameIndex i = 0; i < 300; ++i) {
    drive.poses.poses[599 - i].T_map_base = drive.poses.poses[i].T_map_base;
  }
  expect_tiles_of_map(drive);
}

TEST(BuildTiles, ReadsEachCloudOnce) {
  Drive drive(200);
  merged_tiles(drive);
  EXPECT_EQ(drive.clouds.reads, 200U);
}

// Points keep their precision far away from the origin.
TEST(BuildTiles, KeepsMillimetresFarFromOrigin) {
  MemoryClouds clouds;
  clouds.clouds[0] = cloud_of({{1.0F, 1.0F, 0.0F, 0.0F}, {1.601F, 1.0F, 0.0F, 0.0F}});
  KeyFramePoses poses;
  Pose far;
  far.translation = {400'000.0, 4'600'000.0, 0.0};
  poses.poses = {{0, 0, far}};
  std::vector<Point> points;
  const test::TemporaryFolder folder;
  build_tiles(poses, clouds, exact_config(), folder.path(), [&](const MapTile& tile) {
    points.insert(points.end(), tile.cloud.points.begin(), tile.cloud.points.end());
  });
  ASSERT_EQ(points.size(), 2U);
  EXPECT_NEAR(std::abs(points[1].x - points[0].x), 0.601, 1e-4);
}

}  // namespace
}  // namespace lidar_mapping::map
