// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "ndt/ndt_kernels.hpp"
#include "ndt/ndt_neighbors.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

/// Fills a voxel of 1 m with a level plane at this height above its floor.
void add_plate(GaussianVoxelMap& map, const Eigen::Vector3i& cell, float height,
               const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt) {
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector3f p =
        cell.cast<float>() + Eigen::Vector3f(0.1F + 0.2F * static_cast<float>(i / 5),
                                             0.1F + 0.2F * static_cast<float>(i % 5), height);
    map.insert(&p.x(), &p.y(), &p.z(), 1, viewpoint);
  }
}

/// Points at their places, filled up to whole lanes far outside of the map.
class Points {
 public:
  explicit Points(const std::vector<Eigen::Vector3f>& positions) {
    for (const Eigen::Vector3f& p : positions) add(p);
    while (rotated.x.size() % kNdtLanes != 0) add(Eigen::Vector3f::Constant(1e6F));
    locate();
  }

  void move(std::size_t i, const Eigen::Vector3f& to) {
    rotated.x[i] = to.x();
    rotated.y[i] = to.y();
    rotated.z[i] = to.z();
    locate();
  }

  RotatedPoints rotated;
  std::vector<std::int32_t> cells;

 private:
  void add(const Eigen::Vector3f& p) {
    rotated.x.push_back(p.x());
    rotated.y.push_back(p.y());
    rotated.z.push_back(p.z());
  }
  void locate() {
    SweepMotion still{};
    for (const int diagonal : {0, 4, 8}) still.rotation[diagonal] = 1.0F;
    for (int axis = 0; axis < 3; ++axis) still.translation[axis] = rotated.translation[axis];
    const std::size_t count = rotated.x.size();
    const std::vector<float> times(count, 0.0F);
    std::vector<float> scratch[3];
    for (auto& array : scratch) array.resize(count);
    cells.resize(count);
    portable_ndt_kernels().locate(
        still, 1.0F, {rotated.x.data(), rotated.y.data(), rotated.z.data(), times.data()}, count,
        scratch[0].data(), scratch[1].data(), scratch[2].data(), cells.data());
  }
};

Eigen::Vector3f normal_of(const PlaneArrays& planes, std::size_t i) {
  return {planes.x[i], planes.y[i], planes.z[i]};
}

/// Heights (m) at which the level planes of a point lie, ascending.
std::vector<float> plane_heights(const NdtNeighbors& neighbors, std::size_t point) {
  std::vector<float> heights;
  for (std::size_t k = 0; k < neighbors.count(); ++k) {
    const PlaneArrays& planes = neighbors.planes(k);
    const float z = planes.z[point];
    if (z == 0.0F) continue;
    EXPECT_GT(std::abs(z), 0.99F * normal_of(planes, point).norm()) << "not level";
    heights.push_back(planes.offset[point] / z);
  }
  std::sort(heights.begin(), heights.end());
  return heights;
}

void find(const Points& points, NeighborSearch search, GaussianVoxelMap& map,
          NdtNeighbors& neighbors) {
  neighbors.begin(points.cells.size(), search);
  neighbors.update(points.cells, points.rotated, map);
}

std::vector<float> found_heights(GaussianVoxelMap& map, NeighborSearch search,
                                 const Eigen::Vector3f& position) {
  NdtNeighbors neighbors;
  find(Points({position}), search, map, neighbors);
  return plane_heights(neighbors, 0);
}

void expect_heights(const std::vector<float>& actual, const std::vector<float>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i], expected[i], 1e-3F) << i;
}

TEST(NdtNeighbors, GiveThePlaneOfTheVoxelOfEachPoint) {
  GaussianVoxelMap map(1.0, 256);
  add_plate(map, {0, 0, 0}, 0.3F);
  add_plate(map, {-1, 0, 0}, 0.7F);
  add_plate(map, {0, -300, 5}, 0.5F);
  const Points points(
      {{0.5F, 0.5F, 0.9F}, {-0.5F, 0.5F, 0.1F}, {0.5F, -299.5F, 5.1F}, {7.0F, 7.0F, 7.0F}});
  NdtNeighbors neighbors;
  find(points, NeighborSearch::kDirect1, map, neighbors);
  ASSERT_EQ(neighbors.count(), 1U);
  expect_heights(plane_heights(neighbors, 0), {0.3F});
  expect_heights(plane_heights(neighbors, 1), {0.7F});
  expect_heights(plane_heights(neighbors, 2), {5.5F});
  for (std::size_t i = 3; i < points.cells.size(); ++i) {
    EXPECT_TRUE(normal_of(neighbors.planes(0), i).isZero(0.0F)) << i << ": nothing is there";
  }
}

// A level surface in each of the 27 voxels around the point, 1 cm higher from one to the next.
TEST(NdtNeighbors, AreSevenVoxelsThatShareAFace) {
  GaussianVoxelMap map(1.0, 256);
  std::vector<float> by_face;
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
    const float height = 0.3F + 0.01F * static_cast<float>(i);
    add_plate(map, offset, height);
    if (offset.cwiseAbs().sum() <= 1) by_face.push_back(static_cast<float>(offset.z()) + height);
  }
  std::sort(by_face.begin(), by_face.end());
  ASSERT_EQ(by_face.size(), 7U);
  const Eigen::Vector3f middle(0.5F, 0.5F, 0.5F);
  expect_heights(found_heights(map, NeighborSearch::kDirect7, middle), by_face);
  expect_heights(found_heights(map, NeighborSearch::kDirect1, middle), {0.43F});
}

TEST(NdtNeighbors, OfARadiusSearchHaveTheirMeansWithinAVoxelEdge) {
  GaussianVoxelMap map(1.0, 256);
  add_plate(map, {0, 0, 0}, 0.5F);
  add_plate(map, {0, 0, 1}, 0.2F);  // its mean lies at (0.5, 0.5, 1.2)
  add_plate(map, {1, 1, 0}, 0.6F);  // its mean lies at (1.5, 1.5, 0.6)
  const auto search = NeighborSearch::kKdTree;
  expect_heights(found_heights(map, search, {0.5F, 0.5F, 0.5F}), {0.5F, 1.2F});
  expect_heights(found_heights(map, search, {0.5F, 0.5F, 0.1F}), {0.5F});
  expect_heights(found_heights(map, search, {0.95F, 0.95F, 0.6F}), {0.5F, 0.6F, 1.2F});
  expect_heights(found_heights(map, search, {0.01F, 0.01F, 0.01F}), {0.5F});
  expect_heights(found_heights(map, search, {0.0F, 0.0F, -0.5F}), {});
}

// The map changes between two matches, not within one.
TEST(NdtNeighbors, KeepThePlaneUntilThePointIsInAnotherVoxel) {
  GaussianVoxelMap map(1.0, 256);
  add_plate(map, {0, 0, 0}, 0.3F);
  Points points({{0.5F, 0.5F, 0.5F}, {0.5F, 0.5F, 0.6F}});
  NdtNeighbors neighbors;
  find(points, NeighborSearch::kDirect1, map, neighbors);
  map.clear();
  add_plate(map, {0, 0, 0}, 0.8F);
  points.move(0, {0.9F, 0.1F, 0.2F});
  neighbors.update(points.cells, points.rotated, map);
  expect_heights(plane_heights(neighbors, 0), {0.3F});
  points.move(0, {1.1F, 0.1F, 0.2F});
  neighbors.update(points.cells, points.rotated, map);
  expect_heights(plane_heights(neighbors, 0), {});
  points.move(0, {0.9F, 0.1F, 0.2F});
  neighbors.update(points.cells, points.rotated, map);
  expect_heights(plane_heights(neighbors, 0), {0.8F});
  expect_heights(plane_heights(neighbors, 1), {0.3F});
}

TEST(NdtNeighbors, DiscardAllPlanesAtTheBeginning) {
  GaussianVoxelMap map(1.0, 256);
  add_plate(map, {0, 0, 0}, 0.3F);
  const Points points({{0.5F, 0.5F, 0.5F}});
  NdtNeighbors neighbors;
  for (const float height : {0.3F, 0.8F}) {
    map.clear();
    add_plate(map, {0, 0, 0}, height);
    find(points, NeighborSearch::kDirect1, map, neighbors);
    expect_heights(plane_heights(neighbors, 0), {height});
  }
}

TEST(NdtNeighbors, FollowAChangeOfTheSearch) {
  GaussianVoxelMap map(1.0, 256);
  for (const int z : {-1, 0, 1}) add_plate(map, {0, 0, z}, 0.5F);
  const Points points({{0.5F, 0.5F, 0.5F}});
  NdtNeighbors neighbors;
  for (const auto& [search, planes] :
       {std::pair(NeighborSearch::kDirect7, 3U), std::pair(NeighborSearch::kDirect1, 1U),
        std::pair(NeighborSearch::kDirect7, 3U)}) {
    find(points, search, map, neighbors);
    EXPECT_EQ(plane_heights(neighbors, 0).size(), planes);
  }
}

// A thin slab: its floor is seen from above, its ceiling from below. The map tells them apart as
// soon as it was asked for the plane of the one.
TEST(NdtNeighbors, AreTheSideThatFacesTheSensor) {
  GaussianVoxelMap map(1.0, 256);
  const Eigen::Vector3f above(0.5F, 0.5F, 3.0F), below(0.5F, 0.5F, -3.0F);
  add_plate(map, {0, 0, 0}, 0.6F, above);
  map.plane(Eigen::Vector3i::Zero());
  add_plate(map, {0, 0, 0}, 0.4F, below);
  Points points({{0.5F, 0.5F, 0.5F}});
  for (const auto& [viewpoint, height] : {std::pair(above, 0.6F), std::pair(below, 0.4F)}) {
    points.rotated.viewpoint = viewpoint;
    NdtNeighbors neighbors;
    find(points, NeighborSearch::kDirect1, map, neighbors);
    expect_heights(plane_heights(neighbors, 0), {height});
  }
}

TEST(NdtNeighbors, OfNoPointsAreNone) {
  GaussianVoxelMap map(1.0, 256);
  NdtNeighbors neighbors;
  neighbors.begin(0, NeighborSearch::kDirect7);
  neighbors.update({}, RotatedPoints{}, map);
  EXPECT_EQ(neighbors.count(), 7U);
  EXPECT_TRUE(neighbors.planes(0).x.empty());
}

TEST(RotatedPoints, HaveTheirPositionAndTheDirectionToTheSensor) {
  RotatedPoints points;
  points.x = {1.0F};
  points.y = {2.0F};
  points.z = {3.0F};
  points.translation = {10.0F, 20.0F, 30.0F};
  EXPECT_EQ(points.position(0), Eigen::Vector3f(11.0F, 22.0F, 33.0F));
  EXPECT_EQ(points.view(0), Eigen::Vector3f::Zero()) << "unknown";
  points.viewpoint = Eigen::Vector3f(0.0F, 0.0F, 5.0F);
  EXPECT_EQ(points.view(0), Eigen::Vector3f(-1.0F, -2.0F, 2.0F)) << "without the translation";
}

}  // namespace
}  // namespace lidar_mapping::registration
