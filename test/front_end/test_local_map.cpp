// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "local_map/local_map.hpp"
#include "near.hpp"
#include "sampled_points.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionState;

constexpr double kVoxel = 1.0;    // m
constexpr double kRadius = 40.0;  // m

/// Random points within 20 m of the sensor.
std::vector<Eigen::Vector3f> surroundings(std::size_t count) {
  std::mt19937 engine(2);
  std::uniform_real_distribution<float> place(-20.0F, 20.0F), up(-2.0F, 4.0F);
  std::vector<Eigen::Vector3f> points;
  while (points.size() < count) {
    const float x = place(engine), y = place(engine);
    points.emplace_back(x, y, up(engine));
  }
  return points;
}

MotionState at(const Pose& pose) { return {pose, Vector6d::Zero()}; }

MotionState at(double x, double y = 0.0) { return at(Pose{exp_so3({0.0, 0.0, 0.0}), {x, y, 0.0}}); }

std::size_t points_in(const registration::GaussianVoxelMap& map) {
  std::size_t sum = 0;
  for (const registration::Gaussian& gaussian : map.gaussians()) {
    sum += static_cast<std::size_t>(gaussian.count);
  }
  return sum;
}

Eigen::Vector3d transformed(const Eigen::Vector3f& p, const MotionState& state, float seconds,
                            const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  SampledPoints result;
  transform_points(sampled({p}, seconds), state, origin, result);
  EXPECT_EQ(result.x.size(), 1U);
  return Eigen::Vector3f(result.x[0], result.y[0], result.z[0]).cast<double>();
}

TEST(TransformPoints, PutsPointsWhereTheSensorIs) {
  const Pose pose{exp_so3({0.1, -0.2, 2.0}), {1000.0, -2000.0, 30.0}};
  const Eigen::Vector3f p(5.0F, 3.0F, -1.0F);
  const Eigen::Vector3d origin(990.0, -1990.0, 20.0);
  EXPECT_TRUE(
      test::near(transformed(p, at(pose), 0.05F, origin), pose * p.cast<double>() - origin, 1e-5));
}

TEST(TransformPoints, FollowsTheMotionDuringTheSweep) {
  MotionState driving = at(Pose());
  driving.twist << 20.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  EXPECT_TRUE(test::near(transformed({5.0F, 3.0F, 0.0F}, driving, 0.05F),
                         Eigen::Vector3d(6.0, 3.0, 0.0), 1e-5));
  EXPECT_TRUE(test::near(transformed({5.0F, 3.0F, 0.0F}, driving, -0.05F),
                         Eigen::Vector3d(4.0, 3.0, 0.0), 1e-5));
  MotionState turning = at(Pose());
  turning.twist << 0.0, 0.0, 0.0, 0.0, 0.0, 2.0;
  const double angle = 2.0 * 0.05;
  EXPECT_TRUE(test::near(transformed({10.0F, 0.0F, 0.0F}, turning, 0.05F),
                         Eigen::Vector3d(10.0 * std::cos(angle), 10.0 * std::sin(angle), 0.0),
                         2e-3))
      << "to the second order of the angle";
}

TEST(LocalMap, HasAPointForEachVoxelWhereThePointsAre) {
  LocalMap map(kVoxel, kRadius);
  EXPECT_TRUE(map.empty());
  const Pose pose{exp_so3({0.0, 0.0, 1.0}), {7.0, -3.0, 0.4}};
  const std::vector<Eigen::Vector3f> points = surroundings(3000);
  map.insert(sampled(points), at(pose));
  EXPECT_FALSE(map.empty());
  std::set<std::tuple<int, int, int>> voxels;
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3d q = pose * p.cast<double>();
    voxels.insert({static_cast<int>(std::floor(q.x())), static_cast<int>(std::floor(q.y())),
                   static_cast<int>(std::floor(q.z()))});
  }
  const PointCloud cloud = map.cloud();
  EXPECT_NEAR(static_cast<double>(cloud.size()), static_cast<double>(voxels.size()), 3.0)
      << "but for points on borders of voxels";
  EXPECT_EQ(points_in(map.fine()), points.size());
  EXPECT_EQ(map.dropped_points(), 0U);
}

// Its voxels are three times as large and need fewer points for the same planes.
TEST(LocalMap, HasACoarseMapOfFewerPoints) {
  for (const auto& [density, expected] :
       {std::pair(1.0, 100U), std::pair(0.5, 200U), std::pair(0.25, 400U), std::pair(0.01, 400U)}) {
    LocalMap map(kVoxel, kRadius);
    map.set_scan_density(density);
    EXPECT_EQ(map.scan_density(), density);
    map.insert(sampled(surroundings(400)), at(0.0));
    EXPECT_EQ(points_in(map.fine()), 400U) << density;
    EXPECT_EQ(points_in(map.coarse()), expected) << density;
    EXPECT_NEAR(map.coarse().resolution(), 3.0 * map.fine().resolution(), 1e-12);
  }
}

TEST(LocalMap, DiscardsWhatIsFarAwayAfterSomeScans) {
  LocalMap map(kVoxel, kRadius);
  map.insert(sampled(surroundings(500)), at(0.0));
  map.insert(sampled(surroundings(500)), at(100.0));
  for (int scan = 0; scan < 64; ++scan) map.set_center({100.0, 0.0, 0.0});
  const PointCloud cloud = map.cloud();
  EXPECT_FALSE(map.empty());
  for (const Point& point : cloud.points) {
    EXPECT_TRUE(test::near(point.position(), Eigen::Vector3f(100.0F, 0.0F, 0.0F), kRadius + 2.0));
  }
  EXPECT_EQ(points_in(map.fine()), 500U) << "what is near stays";
}

// 64 calls are six seconds: a part of the table with each scan.
TEST(LocalMap, DiscardsAPartOfItWithEachScan) {
  LocalMap map(kVoxel, kRadius);
  map.insert(sampled(surroundings(5000)), at(0.0));
  const std::size_t before = map.fine().size();
  map.set_center({1000.0, 0.0, 0.0});
  EXPECT_GT(map.fine().size(), before * 9 / 10);
  EXPECT_LT(map.fine().size(), before);
}

// Floats have steps of 1 mm at 10 km, and the map must not feel them.
TEST(LocalMap, IsAsExactFarFromTheStart) {
  std::vector<Eigen::Vector3f> plane;
  for (int i = 0; i < 100; ++i) {
    plane.emplace_back(5.05F + 0.09F * static_cast<float>(i / 10),
                       0.05F + 0.09F * static_cast<float>(i % 10), -1.4567F);
  }
  LocalMap map(kVoxel, kRadius);
  const Eigen::Vector3d far(123'000.0, -45'000.0, 0.0);
  map.set_center(far);
  EXPECT_TRUE(test::near(map.fine().origin(), far, 64.0));
  map.insert(sampled(plane), at(Pose{exp_so3({0.0, 0.0, 0.0}), far}));
  const auto gaussians = map.fine().gaussians();
  ASSERT_EQ(gaussians.size(), 1U);
  const Eigen::Vector3d mean = gaussians.front().mean + map.fine().origin() - far;
  EXPECT_TRUE(test::near(mean, Eigen::Vector3d(5.455, 0.455, -1.4567), 1e-3));
  EXPECT_LT(gaussians.front().covariance(2, 2), 1e-6) << "as thin as it was";
}

TEST(LocalMap, StaysWhereItIsWhenItsOriginFollowsTheSensor) {
  LocalMap map(kVoxel, 1e4);
  const std::vector<Eigen::Vector3f> points = surroundings(500);
  map.insert(sampled(points), at(0.0));
  const PointCloud before = map.cloud();
  for (double x = 0.0; x <= 300.0; x += 10.0) {
    map.set_center({x, -0.5 * x, 0.0});
    EXPECT_LT((map.fine().origin() - Eigen::Vector3d(x, -0.5 * x, 0.0)).cwiseAbs().maxCoeff(),
              66.0);
    EXPECT_TRUE(test::near(map.coarse().origin(), map.fine().origin(), 1e-9));
  }
  const PointCloud after = map.cloud();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_TRUE(test::near(after.points[i].position(), before.points[i].position(), 1e-3)) << i;
  }
  // The same points again fall into the same voxels.
  map.insert(sampled(points), at(0.0));
  EXPECT_NEAR(static_cast<double>(map.cloud().size()), static_cast<double>(before.size()), 3.0);
}

TEST(LocalMap, BeginsAnewWithVoxelsOfAnotherSize) {
  LocalMap map(kVoxel, kRadius);
  const Eigen::Vector3d far(5'000.0, 0.0, 0.0);
  map.set_center(far);
  map.insert(sampled(surroundings(200)), at(5'000.0));
  map.restart(0.4);
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.coarse().size(), 0U);
  EXPECT_NEAR(map.fine().resolution(), 0.4, 1e-12);
  EXPECT_NEAR(map.coarse().resolution(), 1.2, 1e-12);
  EXPECT_TRUE(test::near(map.fine().origin(), far, 65.0)) << "where the sensor is";
  map.insert(sampled({{1.0F, 1.0F, 1.0F}}), at(5'000.0));
  ASSERT_EQ(map.cloud().size(), 1U);
  EXPECT_TRUE(
      test::near(map.cloud().points[0].position(), Eigen::Vector3f(5'001.0F, 1.0F, 1.0F), 2e-3));
  map.clear();
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.cloud().size(), 0U);
}

// A slab between two storeys: the one side is seen from above, the other from below.
TEST(LocalMap, KeepsTheSidesOfASlabApartIfThePlaceOfTheSensorIsKnown) {
  for (const bool known : {true, false}) {
    LocalMap map(kVoxel, kRadius);
    for (const float side : {1.0F, -1.0F}) {
      std::vector<Eigen::Vector3f> plate;
      for (int i = 0; i < 100; ++i) {
        plate.emplace_back(0.05F + 0.1F * static_cast<float>(i / 10),
                           0.05F + 0.1F * static_cast<float>(i % 10), 0.5F + 0.1F * side);
      }
      SampledPoints points = sampled(plate);
      if (known) points.viewpoint = Eigen::Vector3f(0.5F, 0.5F, 0.5F + 3.0F * side);
      map.insert(points, at(0.0));
      map.fine().plane(Eigen::Vector3i::Zero());  // as a match asks for it
    }
    EXPECT_EQ(map.fine().size(), known ? 2U : 1U);
  }
}

TEST(LocalMap, CountsPointsForWhichItHasNoRoom) {
  LocalMap map(0.1, 1e4);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 400; ++i) {
    for (int j = 0; j < 400; ++j) {
      points.emplace_back(0.1F * static_cast<float>(i) + 0.05F,
                          0.1F * static_cast<float>(j) + 0.05F, 0.05F);
    }
  }
  std::size_t inserted = 0;
  for (int scan = 1; scan <= 2; ++scan) {
    map.insert(sampled(points), at(0.0));
    inserted += points.size();
    EXPECT_GT(map.dropped_points(), 0U);
    EXPECT_EQ(points_in(map.fine()) + map.dropped_points(), inserted) << scan;
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
