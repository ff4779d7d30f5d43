// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "corner_map.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

TEST(GaussianVoxelMap, GivesMeanAndCovarianceOfItsPoints) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  GaussianVoxelMap map(2.0, 64);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  constexpr int kCount = 500;
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3f p(2.0F * unit(engine), unit(engine), 0.2F * unit(engine));
    map.insert(&p.x(), &p.y(), &p.z(), 1);
    sum += p.cast<double>();
    products += (p * p.transpose()).cast<double>();
  }
  const Gaussian gaussian = map.gaussian({0, 0, 0});
  const Eigen::Vector3d mean = sum / kCount;
  EXPECT_EQ(gaussian.count, kCount);
  EXPECT_TRUE(test::near(gaussian.mean, mean, 1e-5));
  EXPECT_TRUE(test::near(gaussian.covariance, products / kCount - mean * mean.transpose(), 2e-3));
}

TEST(GaussianVoxelMap, PlaneIsThinAcrossTheSurface) {
  GaussianVoxelMap map = corner_map();
  const WeightedPlane ground = map.plane({2, -12, -2});
  EXPECT_GT(std::abs(ground.normal.normalized().z()), 0.99F);
  const Eigen::Vector3f on_the_ground(2.5F, -11.5F, -1.7F);
  const float deviations = ground.normal.dot(on_the_ground) - ground.offset;
  EXPECT_LT(std::abs(deviations) / ground.normal.norm(), 0.02F);
  EXPECT_EQ(map.plane({400, 0, 0}).normal.norm(), 0.0F);
}

TEST(GaussianVoxelMap, TakesALineForNoPlane) {
  GaussianVoxelMap map(1.0, 64);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3f p(0.01F * static_cast<float>(i), 0.5F, 0.5F);
    map.insert(&p.x(), &p.y(), &p.z(), 1);
  }
  EXPECT_EQ(map.plane({0, 0, 0}).normal.norm(), 0.0F);
}

// The noise of the ranges widens a piece of a ring along the beams; a plane through it would lean
// towards the sensor and hold the sensor where it is.
TEST(GaussianVoxelMap, TakesAPieceOfARingOnTheGroundForNoPlane) {
  std::mt19937 engine(1);
  std::normal_distribution<float> noise(0.0F, 0.02F);
  const Eigen::Vector3f beam(std::cos(-0.26F), 0.0F, std::sin(-0.26F));
  GaussianVoxelMap map(1.0, 64);
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3f on_ground(0.5F, 0.3F + 0.01F * static_cast<float>(i), 0.5F);
    const Eigen::Vector3f p = on_ground + noise(engine) * beam;
    map.insert(&p.x(), &p.y(), &p.z(), 1);
  }
  EXPECT_EQ(map.plane({0, 0, 0}).normal.norm(), 0.0F);
}

/// Points of a piece of three rings, one from each of three places on the way, that scatter by
/// `depth` (m) along the beam: on leaves if that is much.
GaussianVoxelMap three_rings_in_a_voxel(float depth, double ring_spacing) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> across(0.0F, 1.0F);
  std::uniform_real_distribution<float> along(-0.5F, 0.5F);
  GaussianVoxelMap map(1.0, 64);
  map.set_ring_spacing(ring_spacing);
  for (int ring = 0; ring < 3; ++ring) {
    const float height = 0.4F + 0.1F * static_cast<float>(ring);
    for (int i = 0; i < 30; ++i) {
      const float surface = 0.3F + 0.5F * height;
      const Eigen::Vector3f p(surface + depth * along(engine), across(engine), height);
      map.insert(&p.x(), &p.y(), &p.z(), 1);
    }
  }
  return map;
}

/// Steepness of the plane's normal as a sensor finds it that is `distance` (m) away.
float steepness_seen_from(float distance, GaussianVoxelMap map) {
  const Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  const Eigen::Vector3f view(-distance, 0.0F, 0.0F);
  const Eigen::Vector3f normal = map.plane(cell, map.slot_of(cell), view).normal;
  EXPECT_GT(normal.norm(), 0.0F);
  return std::abs(normal.z()) / normal.norm();
}

// The ring passes over the leaves as the sensor moves on, and so does the height of the points.
TEST(GaussianVoxelMap, RingsOnLeavesSayNothingAboutTheHeight) {
  constexpr double kTwoDegrees = 2.0 * kRadPerDeg;
  constexpr float kLeaves = 0.6F;
  constexpr float kWall = 0.0F;
  EXPECT_GT(steepness_seen_from(40.0F, three_rings_in_a_voxel(kLeaves, 0.0)), 0.3F);
  EXPECT_GT(steepness_seen_from(5.0F, three_rings_in_a_voxel(kLeaves, kTwoDegrees)), 0.3F);
  EXPECT_LT(steepness_seen_from(40.0F, three_rings_in_a_voxel(kLeaves, kTwoDegrees)), 0.01F);
  EXPECT_NEAR(steepness_seen_from(40.0F, three_rings_in_a_voxel(kWall, kTwoDegrees)),
              std::sqrt(0.2F), 0.02F);
}

/// A level plate of 1 m at `height`, seen from `viewpoint`.
void insert_plate(float height, const Eigen::Vector3f& viewpoint, std::uint32_t seed,
                  GaussianVoxelMap& map) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> across(0.0F, 1.0F);
  std::normal_distribution<float> noise(0.0F, 0.01F);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3f p(across(engine), across(engine), height + noise(engine));
    map.insert(&p.x(), &p.y(), &p.z(), 1, viewpoint);
  }
}

/// Height of the plane that a sensor at `viewpoint` finds, if any.
std::optional<float> height_seen(const Eigen::Vector3f& viewpoint, GaussianVoxelMap& map) {
  const Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  const Eigen::Vector3f middle(0.5F, 0.5F, 0.5F);
  const WeightedPlane plane = map.plane(cell, map.slot_of(cell), viewpoint - middle);
  if (plane.normal.norm() == 0.0F) return std::nullopt;
  return (plane.offset - plane.normal.head<2>().dot(middle.head<2>())) / plane.normal.z();
}

TEST(GaussianVoxelMap, KeepsFloorAndCeilingOfASlabApart) {
  GaussianVoxelMap map(1.0, 64);
  const Eigen::Vector3f below(-3.0F, 0.5F, -0.5F);
  const Eigen::Vector3f above(-3.0F, 0.5F, 2.5F);
  const Eigen::Vector3f level(-9.0F, 0.5F, 0.6F);
  insert_plate(0.4F, below, 1, map);
  EXPECT_NEAR(height_seen(below, map).value_or(0.0F), 0.4F, 0.01F);
  EXPECT_FALSE(height_seen(above, map));
  insert_plate(0.65F, above, 2, map);
  EXPECT_NEAR(height_seen(above, map).value_or(0.0F), 0.65F, 0.01F);
  EXPECT_NEAR(height_seen(below, map).value_or(0.0F), 0.4F, 0.01F);
  // A glance along the slab tells nothing about its sides.
  EXPECT_NEAR(height_seen(level, map).value_or(0.0F), 0.4F, 0.01F);
}

// A map that is made without any match would have one plane in the middle of the slab.
TEST(GaussianVoxelMap, KeepsThemApartWithoutAMatchIfItsPlanesAreUpdated) {
  GaussianVoxelMap map(1.0, 64);
  const Eigen::Vector3f below(-3.0F, 0.5F, -0.5F);
  const Eigen::Vector3f above(-3.0F, 0.5F, 2.5F);
  const Eigen::Vector3f seen(0.5F, 0.5F, 0.4F);
  insert_plate(0.4F, below, 1, map);
  map.update_planes(&seen.x(), &seen.y(), &seen.z(), 1, below);
  insert_plate(0.65F, above, 2, map);
  EXPECT_NEAR(height_seen(above, map).value_or(0.0F), 0.65F, 0.01F);
  EXPECT_NEAR(height_seen(below, map).value_or(0.0F), 0.4F, 0.01F);
}

// What is far away is let go of bit by bit, what is near stays, and nothing is rebuilt.
TEST(GaussianVoxelMap, DiscardsOnlyWhatIsFarAway) {
  GaussianVoxelMap map(1.0, 4096);
  for (int x = 0; x < 1000; ++x) {
    const Eigen::Vector3f p(static_cast<float>(x) + 0.5F, 0.5F, 0.5F);
    map.insert(&p.x(), &p.y(), &p.z(), 1);
  }
  for (int step = 0; step < 8; ++step) map.remove_beyond({0.0F, 0.0F, 0.0F}, 100.0F, 0.25);
  EXPECT_EQ(map.size(), 100U);
  for (int x = 0; x < 1000; ++x) {
    ASSERT_EQ(map.gaussian({x, 0, 0}).count, x < 100 ? 1 : 0) << x;
  }
}

// A drive of ten kilometres needs no more memory than its beginning.
TEST(GaussianVoxelMap, StaysOfOneSizeOverALongDrive) {
  GaussianVoxelMap map(1.0, 4096);
  std::size_t largest = 0;
  for (int x = 0; x < 10000; ++x) {
    map.set_origin_cell({x, 0, 0});
    for (int y = -10; y < 10; ++y) {
      const Eigen::Vector3f p(0.5F, static_cast<float>(y) + 0.5F, 0.5F);
      map.insert(&p.x(), &p.y(), &p.z(), 1);
    }
    map.remove_beyond({0.0F, 0.0F, 0.0F}, 50.0F, 1.0 / 16.0);
    largest = std::max(largest, map.size());
  }
  EXPECT_LT(largest, 20U * 70U);
  EXPECT_EQ(map.dropped_points(), 0U);
}

/// A voxel for each x from `first` on.
void insert_row(int first, int count, GaussianVoxelMap& map) {
  for (int x = first; x < first + count; ++x) {
    const Eigen::Vector3f p(static_cast<float>(x) + 0.5F, 0.5F, 0.5F);
    map.insert(&p.x(), &p.y(), &p.z(), 1);
  }
}

// Few voxels are cleared one by one, many with the whole table; voxels that were deleted in between
// have moved others.
TEST(GaussianVoxelMap, ClearingLeavesNothing) {
  GaussianVoxelMap map(1.0, 4096);
  for (const int voxels : {500, 2000, 500}) {
    insert_row(0, voxels, map);
    map.remove_beyond({0.0F, 0.0F, 0.0F}, 200.0F, 1.0);
    insert_row(-300, 100, map);
    map.clear();
    EXPECT_EQ(map.size(), 0U);
    EXPECT_TRUE(map.gaussians().empty());
  }
}

TEST(GaussianVoxelMap, MovingTheOriginMovesNothing) {
  GaussianVoxelMap map = corner_map();
  const Gaussian before = map.gaussian({2, -12, -2});
  map.set_origin_cell({-3, 60, 9});
  const Gaussian after = map.gaussian({5, -72, -11});
  EXPECT_EQ(after.count, before.count);
  EXPECT_TRUE(test::near(after.mean + map.origin(), before.mean, 1e-9));
}

/// The bytes of all voxels, by their keys.
std::map<VoxelKey, std::string> bytes_of_voxels(const GaussianVoxelMap& map) {
  std::map<VoxelKey, std::string> bytes;
  for (const VoxelSums& voxel : map.table().slots()) {
    if (voxel.key == 0) continue;
    bytes[voxel.key] = std::string(reinterpret_cast<const char*>(&voxel), sizeof(VoxelSums));
  }
  return bytes;
}

// Both sides of a slab with their planes, and voxels that have none yet.
TEST(GaussianVoxelMap, TakesBackItsVoxelsBitByBit) {
  GaussianVoxelMap map(1.0, 64);
  const Eigen::Vector3f below(-3.0F, 0.5F, -0.5F);
  const Eigen::Vector3f above(-3.0F, 0.5F, 2.5F);
  insert_plate(0.4F, below, 1, map);
  ASSERT_TRUE(height_seen(below, map));
  insert_plate(0.65F, above, 2, map);
  const auto from_below = height_seen(below, map);
  const auto from_above = height_seen(above, map);
  ASSERT_TRUE(from_below && from_above);
  insert_row(1, 20, map);
  const auto before = bytes_of_voxels(map);
  ASSERT_EQ(before.size(), 22U);

  const auto is_taken = [](VoxelKey key) { return voxel_index(key).x() < 10; };
  std::vector<VoxelSums> taken;
  for (const VoxelSums& voxel : map.table().slots()) {
    if (voxel.key != 0 && is_taken(voxel.key)) taken.push_back(voxel);
  }
  EXPECT_EQ(taken.size(), 11U);
  map.table().remove_if(is_taken);
  EXPECT_EQ(map.size(), 11U);
  EXPECT_EQ(map.gaussian({0, 0, 0}).count, 0);
  EXPECT_EQ(map.gaussian({10, 0, 0}).count, 1);
  EXPECT_FALSE(height_seen(below, map));

  map.set_origin_cell({100, -7, 3});  // the keys do not depend on it
  map.table().grow();
  for (const VoxelSums& voxel : taken) {
    *map.table().find_or_add(map.table().slot_of(voxel.key)) = voxel;
  }
  map.set_origin_cell({0, 0, 0});
  EXPECT_EQ(bytes_of_voxels(map), before);
  EXPECT_EQ(height_seen(below, map), from_below);
  EXPECT_EQ(height_seen(above, map), from_above);
}

}  // namespace
}  // namespace lidar_mapping::registration
