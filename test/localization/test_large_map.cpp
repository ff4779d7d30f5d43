// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "map_parts.hpp"
#include "near.hpp"
#include "stored_voxels.hpp"
#include "temporary_folder.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::near;
using lidar_mapping::test::TemporaryFolder;

/// Scans of a drive, made once.
class StoredClouds : public CloudSource {
 public:
  StoredClouds(const ToyWorld& world, const std::vector<Pose>& path) {
    for (std::size_t i = 0; i < path.size(); ++i) {
      clouds_.push_back(
          std::make_shared<const PointCloud>(world.scan(path[i], static_cast<std::uint32_t>(i))));
    }
  }
  PointCloudPtr cloud(KeyFrameIndex index) override { return clouds_.at(index); }

 private:
  std::vector<PointCloudPtr> clouds_;
};

/// Houses on both sides of a street along x, from 0 to `length` metres.
ToyWorld street(double length) {
  std::mt19937 generator(11);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator);
  };
  ToyWorld world;
  for (double x = -60.0; x < length + 60.0; x += 12.0) {
    for (const double y : {-30.0, -18.0, 8.0, 20.0}) {
      const Eigen::Vector3d low(x + uniform(0.0, 4.0), y + uniform(0.0, 3.0), 0.0);
      const Eigen::Vector3d size(uniform(2.0, 8.0), uniform(2.0, 8.0), uniform(1.0, 9.0));
      world.boxes.push_back({low, low + size});
    }
  }
  return world;
}

/// The power of two that is at least `value`.
std::size_t power_of_two_from(double value) {
  std::size_t power = 16;
  while (static_cast<double>(power) < value) power *= 2;
  return power;
}

/// The same map twice: once as a whole in memory, once in tables that hold a part of it. `share` is
/// what part of all Gaussians the table of fine ones has room for, at least; at most it is twice
/// that.
class TwoMaps {
 public:
  TwoMaps(ToyWorld world, const std::vector<Pose>& path, double share)
      : world_(std::move(world)),
        path_(path),
        clouds_(world_, path),
        whole_(source_of(path), clouds_, {}, folder_.path()),
        slots_(slots_for(share)),
        partial_(source_of(path), clouds_, {}, folder_.path(), 3, slots_) {}

  const ToyWorld& world() const { return world_; }
  /// Inserts all clouds.
  void insert_into(MapSurfaces& surfaces) {
    for (std::size_t i = 0; i < path_.size(); ++i) {
      const PointCloudPtr cloud = clouds_.cloud(static_cast<KeyFrameIndex>(i));
      surfaces.insert(*cloud, path_[i], ToyWorld::sensor());
    }
  }
  /// Of the fine table that holds a part.
  std::size_t slots() const { return slots_; }
  MapIndex& whole() { return whole_; }
  MapIndex& partial() { return partial_; }

 private:
  std::size_t slots_for(double share) const {
    constexpr double kLoad = 0.75;  // of slots, as in voxel_table.cpp
    return power_of_two_from(share / kLoad * static_cast<double>(whole_.gaussians()));
  }

  TemporaryFolder folder_;
  ToyWorld world_;
  std::vector<Pose> path_;
  StoredClouds clouds_;
  MapIndex whole_;
  std::size_t slots_;
  MapIndex partial_;
};

/// Two vehicles that see the same, each in a map of its own.
class TwoVehicles {
 public:
  explicit TwoVehicles(TwoMaps& maps)
      : maps_(maps), in_whole_(maps.whole()), in_partial_(maps.partial()) {}

  /// Goes on to a pose, and holds the two results against each other.
  LocalizationResult go_to(const Pose& truth) {
    ++scans_;
    LocalizerInput input;
    input.scan = {from_seconds(0.1 * scans_),
                  maps_.world().scan(truth, 5000U + static_cast<std::uint32_t>(scans_))};
    input.T_previous_base = last_.inverse() * truth;
    input.covariance = diagonal_covariance(0.01, 0.0005);
    input.p_base_lidar = ToyWorld::sensor();
    last_ = truth;
    const LocalizationResult expected = in_whole_.process(input);
    expect_same(in_partial_.process(input), expected);
    return expected;
  }
  void expect_same_points() {
    const std::vector<MatchedPoint> expected = in_whole_.matched_points();
    const std::vector<MatchedPoint> found = in_partial_.matched_points();
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(found[i].agreement, expected[i].agreement) << i;
    }
  }

 private:
  void expect_same(const LocalizationResult& found, const LocalizationResult& expected) const {
    EXPECT_EQ(found.state, expected.state) << scans_;
    EXPECT_EQ(found.reason, expected.reason) << scans_;
    EXPECT_EQ(found.T_map_base.translation, expected.T_map_base.translation) << scans_;
    EXPECT_EQ(found.T_map_base.rotation.coeffs(), expected.T_map_base.rotation.coeffs()) << scans_;
    EXPECT_EQ(found.covariance, expected.covariance) << scans_;
    EXPECT_EQ(found.probability, expected.probability) << scans_;
    EXPECT_EQ(found.agreement, expected.agreement) << scans_;
    EXPECT_EQ(found.coverage, expected.coverage) << scans_;
    EXPECT_EQ(found.hypotheses, expected.hypotheses) << scans_;
  }

  TwoMaps& maps_;
  Localizer in_whole_;
  Localizer in_partial_;
  Pose last_;
  int scans_ = 0;
};

constexpr int kLength = 1500;  // m
/// Of the long street, a match needs at most six tiles of 48 m, a fifth of its Gaussians.
constexpr double kThird = 0.3;

TwoMaps& long_street() {
  static TwoMaps maps(street(kLength), along({{0.0, 0.0}, {kLength, 0.0}}, 5.0), kThird);
  return maps;
}

TEST(LargeMap, HasTheSurfacesThatItHasInMemory) {
  const TemporaryFolder folder;
  MapSurfaces whole, partial(long_street().slots(), folder.path());
  for (MapSurfaces* const map : {&whole, &partial}) long_street().insert_into(*map);
  EXPECT_EQ(partial.gaussians(), whole.gaussians());
  EXPECT_LT(partial.bytes(), whole.bytes());
  EXPECT_LT(partial.fine().size(), whole.fine().size());
  for (const int x : {900, 0, kLength, 450, 1350, 100}) {
    const Eigen::Vector3d position(x, 0.0, 0.0);
    for (MapSurfaces* const map : {&whole, &partial}) map->require(position, 101.0);
    const auto fine = stored_voxels(whole.fine(), x - 100, x + 100);
    const auto coarse = stored_voxels(whole.coarse(), (x - 100) / 3 + 1, (x + 100) / 3 - 1);
    EXPECT_GT(fine.size(), 1000U) << x;
    EXPECT_GT(coarse.size(), 100U) << x;
    EXPECT_TRUE(stored_voxels(partial.fine(), x - 100, x + 100) == fine) << x;
    EXPECT_TRUE(stored_voxels(partial.coarse(), (x - 100) / 3 + 1, (x + 100) / 3 - 1) == coarse)
        << x;
  }
}

TEST(LargeMap, GivesTheSamePosesAsInMemoryWithoutMoreMemory) {
  TwoMaps& maps = long_street();
  TwoVehicles vehicles(maps);
  const std::size_t bytes = maps.partial().bytes();
  const std::size_t gaussians = maps.partial().gaussians();
  LocalizationResult last;
  const std::vector<Pose> path = along({{30.0, 1.0}, {kLength - 30.0, 1.0}}, 6.0);
  for (const Pose& pose : path) {
    last = vehicles.go_to(pose);
    ASSERT_EQ(maps.partial().bytes(), bytes) << pose.translation.x();
    ASSERT_EQ(maps.partial().gaussians(), gaussians) << pose.translation.x();
  }
  EXPECT_EQ(last.state, LocalizationState::kFollowing) << last.reason;
  EXPECT_TRUE(near(last.T_map_base, path.back(), 0.15, 0.01));
  vehicles.expect_same_points();
}

/// A street, and the same twice more, each 600 m further north.
ToyWorld three_times(const ToyWorld& world) {
  ToyWorld result = world;
  for (const double north : {600.0, 1200.0}) {
    const Eigen::Vector3d shift(0.0, north, 0.0);
    for (const auto& box : world.boxes) result.boxes.push_back({box.low + shift, box.high + shift});
  }
  return result;
}

std::vector<Pose> three_streets() {
  std::vector<Pose> path;
  for (const double y : {0.0, 600.0, 1200.0}) {
    for (const Pose& pose : along({{0.0, y}, {120.0, y}}, 4.0)) path.push_back(pose);
  }
  return path;
}

// Each hypothesis is matched elsewhere, and the table has no room for all of their places.
TEST(LargeMap, HasHypothesesFarApart) {
  constexpr double kOneStreet = 0.4;  // of three
  TwoMaps maps(three_times(street(120.0)), three_streets(), kOneStreet);
  EXPECT_LT(maps.partial().bytes(), maps.whole().bytes());
  TwoVehicles vehicles(maps);
  std::size_t most = 0;
  for (const Pose& pose : along({{10.0, 600.0}, {58.0, 600.0}}, 4.0)) {
    most = std::max(most, vehicles.go_to(pose).hypotheses);
  }
  EXPECT_GE(most, 2U);
}

}  // namespace
}  // namespace lidar_mapping::localization::test
