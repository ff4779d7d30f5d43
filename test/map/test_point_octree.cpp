// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "files/point_octree.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

using Position = std::array<std::int32_t, 3>;
using Nodes = std::map<OctreeKey, std::vector<StoredPoint>>;

/// A street: most points lie on a level surface and a wall, a few far above. Coordinates in mm.
std::vector<StoredPoint> street(std::size_t count) {
  std::mt19937 engine(2);
  std::uniform_int_distribution<std::int32_t> along(-40'000, 60'000), across(-9'000, 9'000);
  std::uniform_int_distribution<std::int32_t> up(0, 8'000);
  std::vector<StoredPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    StoredPoint point;
    point.position = {along(engine), across(engine), 0};
    if (i % 3 == 0) point.position = {point.position[0], 9'000, up(engine)};
    if (i % 900 == 0) point.position[2] = 60'000;
    point.intensity = static_cast<float>(i);
    point.key_frame = static_cast<KeyFrameIndex>(i / 100);
    points.push_back(point);
  }
  return points;
}

OctreeCube cube_around(const std::vector<StoredPoint>& points) {
  Position low = points.front().position, high = low;
  for (const StoredPoint& point : points) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], point.position[i]);
      high[i] = std::max(high[i], point.position[i]);
    }
  }
  return {low, high};
}

/// Divides points, and checks that each node comes once and after its parent.
Nodes divided(const std::vector<StoredPoint>& points, const OctreeCube& cube,
              const OctreeOptions& options = {}) {
  const test::TemporaryFolder folder;
  PointSpool spool(folder.path());
  for (const StoredPoint& point : points) spool.add(point);
  Nodes nodes;
  std::mutex mutex;
  divide_into_octree(std::move(spool), cube, options, folder.path(),
                     [&](const OctreeKey& key, const std::vector<StoredPoint>& own) {
                       const std::lock_guard<std::mutex> lock(mutex);
                       EXPECT_FALSE(own.empty()) << key.name();
                       EXPECT_TRUE(nodes.emplace(key, own).second) << key.name() << " came twice";
                       if (key.depth == 0) return;
                       const OctreeKey parent{key.depth - 1, key.x / 2, key.y / 2, key.z / 2};
                       EXPECT_EQ(nodes.count(parent), 1U) << key.name() << " before its parent";
                     });
  return nodes;
}

std::vector<float> intensities(const Nodes& nodes) {
  std::vector<float> all;
  for (const auto& [key, points] : nodes) {
    for (const StoredPoint& point : points) all.push_back(point.intensity);
  }
  std::sort(all.begin(), all.end());
  return all;
}

void expect_equal(const Nodes& actual, const Nodes& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (const auto& [key, points] : expected) {
    const auto found = actual.find(key);
    ASSERT_NE(found, actual.end()) << key.name();
    ASSERT_EQ(found->second.size(), points.size()) << key.name();
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(found->second[i].intensity, points[i].intensity) << key.name() << ", point " << i;
    }
  }
}

TEST(OctreeKey, HasEightChildrenInItsOctants) {
  const OctreeKey key{2, 1, 3, 0};
  EXPECT_EQ(key.name(), "2-1-3-0");
  EXPECT_EQ(key.child(0).name(), "3-2-6-0");
  EXPECT_EQ(key.child(1).name(), "3-3-6-0") << "bit 0 is x";
  EXPECT_EQ(key.child(2).name(), "3-2-7-0");
  EXPECT_EQ(key.child(4).name(), "3-2-6-1");
  EXPECT_EQ(key.child(7).name(), "3-3-7-1");
}

TEST(OctreeCube, HoldsAllPointsWithTheSameCentre) {
  const OctreeCube cube({-40'000, -9'000, 100}, {60'000, 9'000, 8'100});
  const Position low = {-40'000, -9'000, 100}, high = {60'000, 9'000, 8'100};
  EXPECT_GT(cube.edge, 100'000) << "a point at the upper end lies inside";
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE(cube.corner[i], low[i]);
    EXPECT_GT(cube.corner[i] + cube.edge, high[i]);
    EXPECT_NEAR(static_cast<double>(2 * cube.corner[i] + cube.edge), low[i] + high[i], 2.0);
  }
}

TEST(OctreeCube, HasNodesOfWholeMillimetres) {
  for (const std::int32_t extent : {0, 1, 16'383, 16'384, 123'456, 2'000'000'000}) {
    const OctreeCube cube({0, 0, 0}, {extent, extent / 2, 0});
    EXPECT_EQ(cube.edge % (std::int64_t{1} << OctreeCube::kMaxDepth), 0) << extent;
    OctreeKey key;
    for (int depth = 0; depth < OctreeCube::kMaxDepth; ++depth) {
      const OctreeKey child = key.child(7);
      EXPECT_EQ(2 * cube.edge_of(child), cube.edge_of(key)) << extent;
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(cube.corner_of(child)[i], cube.corner_of(key)[i] + cube.edge_of(child));
      }
      key = child;
    }
    EXPECT_GE(cube.edge_of(key), 1) << extent;
  }
}

// The ends of what 32 bits hold.
TEST(OctreeCube, DoesNotOverflow) {
  constexpr std::int32_t kLow = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHigh = std::numeric_limits<std::int32_t>::max();
  const OctreeCube cube({kLow, kLow, kLow}, {kHigh, kHigh, kHigh});
  EXPECT_LE(cube.corner[0], kLow);
  EXPECT_GT(cube.corner[0] + cube.edge, kHigh);
}

TEST(PointOctree, HasEachPointOnceInANodeAroundIt) {
  const std::vector<StoredPoint> points = street(90'000);
  const OctreeCube cube = cube_around(points);
  const Nodes nodes = divided(points, cube);
  EXPECT_GT(nodes.size(), 4U);
  for (const auto& [key, own] : nodes) {
    const auto corner = cube.corner_of(key);
    for (const StoredPoint& point : own) {
      for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_GE(point.position[i], corner[i]) << key.name();
        ASSERT_LT(point.position[i], corner[i] + cube.edge_of(key)) << key.name();
      }
      const StoredPoint& given = points[static_cast<std::size_t>(point.intensity)];
      ASSERT_EQ(point.position, given.position);
      ASSERT_EQ(point.key_frame, given.key_frame);
    }
  }
  const std::vector<float> all = intensities(nodes);
  ASSERT_EQ(all.size(), points.size());
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], static_cast<float>(i));
}

using Cell = std::array<std::int64_t, 3>;

/// The cells of the root in which points lie.
std::set<Cell> cells_of_root(const std::vector<StoredPoint>& points, const OctreeCube& cube) {
  std::set<Cell> cells;
  for (const StoredPoint& point : points) {
    Cell cell{};
    for (std::size_t i = 0; i < 3; ++i) {
      cell[i] = (point.position[i] - cube.corner[i]) * OctreeOptions::kSpan / cube.edge;
    }
    cells.insert(cell);
  }
  return cells;
}

// A level is a picture of its whole cube: no two of its points share a cell.
TEST(PointOctree, GivesEachCellOnePointOfALevel) {
  std::mt19937 engine(1);
  std::uniform_int_distribution<std::int32_t> place(0, 100'000);
  std::vector<StoredPoint> points;
  for (int i = 0; i < 200'000; ++i) points.push_back({{place(engine), place(engine), 0}, 0.0F, 0});
  const OctreeCube cube({0, 0, 0}, {100'000, 100'000, 0});
  const Nodes nodes = divided(points, cube);
  const std::vector<StoredPoint>& root = nodes.at({});
  EXPECT_EQ(cells_of_root(root, cube).size(), root.size());
  EXPECT_GT(root.size(), 10'000U) << "of 128 by 128 cells those that the map fills";
}

// What a viewer shows first: points everywhere, none of them crowded.
TEST(PointOctree, RootIsACoarsePictureOfTheWhole) {
  const std::vector<StoredPoint> points = street(90'000);
  const OctreeCube cube = cube_around(points);
  const Nodes nodes = divided(points, cube);
  const std::size_t in_root = cells_of_root(nodes.at({}), cube).size();
  EXPECT_EQ(in_root, cells_of_root(points, cube).size()) << "every occupied cell has a point";
  const std::size_t more = nodes.at({}).size() - in_root;
  EXPECT_LT(more, 8U * 500U) << "no more than what children with few points leave to it";
}

TEST(PointOctree, DoesNotDependOnThreads) {
  const std::vector<StoredPoint> points = street(90'000);
  const OctreeCube cube = cube_around(points);
  OctreeOptions options;
  options.threads = 1;
  const Nodes expected = divided(points, cube, options);
  options.threads = 4;
  expect_equal(divided(points, cube, options), expected);
}

TEST(PointOctree, IsTheSameOnTheDisk) {
  const std::vector<StoredPoint> points = street(90'000);
  const OctreeCube cube = cube_around(points);
  OctreeOptions options;
  options.points_in_memory = 1;
  expect_equal(divided(points, cube, options), divided(points, cube));
}

TEST(PointOctree, LeavesFewPointsInOneNode) {
  const std::vector<StoredPoint> points = street(5'000);
  const Nodes nodes = divided(points, cube_around(points));
  ASSERT_EQ(nodes.size(), 1U);
  EXPECT_EQ(nodes.at({}).size(), points.size());
}

TEST(PointOctree, HasNoNodeWithoutPoints) {
  EXPECT_TRUE(divided({}, OctreeCube({0, 0, 0}, {1000, 1000, 1000})).empty());
}

// A vehicle that stood still: no division separates points of one place.
TEST(PointOctree, EndsAtItsDepthWithPointsOfOnePlace) {
  std::vector<StoredPoint> points = street(2);
  points.resize(41'000, points.back());
  for (std::size_t i = 0; i < points.size(); ++i) points[i].intensity = static_cast<float>(i);
  const Nodes nodes = divided(points, cube_around(points));
  EXPECT_EQ(intensities(nodes).size(), points.size());
  for (const auto& [key, own] : nodes) EXPECT_LE(key.depth, OctreeCube::kMaxDepth);
}

}  // namespace
}  // namespace lidar_mapping::map
