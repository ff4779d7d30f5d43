// SPDX-License-Identifier: BSD-3-Clause
// Map and search of vertical structures, on a few poles and walls. What is made of them is tested
// in test_false_standstill_recovery.cpp.

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "local_map/vertical_structure_search.hpp"
#include "near.hpp"
#include "sampled_points.hpp"
#include "scan/displaced.hpp"

namespace lidar_mapping::front_end {
namespace {

using Point = Eigen::Vector3f;
using Points = std::vector<Point>;

/// Points up a pole, one for each voxel of the map.
Points pole(float x, float y, int count = 6) {
  Points points;
  for (int i = 0; i < count; ++i) points.emplace_back(x, y, 0.3F * static_cast<float>(i) + 0.15F);
  return points;
}

/// Poles at 6 m, at these azimuths (degrees).
Points poles(const std::vector<double>& azimuths) {
  Points points;
  for (const double azimuth : azimuths) {
    const double rad = azimuth * kPi / 180.0;
    const Points one =
        pole(static_cast<float>(6.0 * std::cos(rad)), static_cast<float>(6.0 * std::sin(rad)));
    points.insert(points.end(), one.begin(), one.end());
  }
  return points;
}

/// A forest without order.
Points forest(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> place(-30.0F, 30.0F);
  Points points;
  for (int i = 0; i < 40; ++i) {
    const float x = place(engine);
    const Points tree = pole(x, place(engine));
    points.insert(points.end(), tree.begin(), tree.end());
  }
  return points;
}

/// These points of the map, in the axes of a sensor at this pose.
Points seen_from(const Points& world, const Pose& T_map_sensor) {
  const Eigen::Isometry3f T_sensor_map(T_map_sensor.inverse().matrix().cast<float>());
  Points points;
  for (const Point& p : world) points.push_back(T_sensor_map * p);
  return points;
}

VerticalStructureMap map_of(const Points& points, const Pose& T_map_sensor = Pose()) {
  VerticalStructureMap map;
  map.insert(points, T_map_sensor);
  return map;
}

// Which points belong to vertical structures.

TEST(VerticalStructurePoints, LieHalfAMetreAboveTheLowestOfTheirColumn) {
  const Points points = {{0.2F, 0.2F, 3.0F},
                         {0.8F, 0.9F, 0.0F},
                         {0.5F, 0.5F, 0.49F},
                         {0.5F, 0.4F, 0.5F},
                         {1.2F, 0.2F, 3.0F}};  // the last one is alone
  EXPECT_EQ(vertical_structure_points(sampled(points)), (Points{points[0], points[3]}));
}

TEST(VerticalStructurePoints, HaveColumnsOfTheSameSizeAroundTheSensor) {
  // Cut off towards zero, both would be in one column.
  EXPECT_TRUE(
      vertical_structure_points(sampled({{-0.2F, 0.2F, 0.0F}, {0.2F, 0.2F, 2.0F}})).empty());
  EXPECT_TRUE(
      vertical_structure_points(sampled({{0.2F, -0.2F, 0.0F}, {0.2F, 0.2F, 2.0F}})).empty());
  EXPECT_EQ(vertical_structure_points(sampled({{-0.2F, -0.2F, 0.0F}, {-0.9F, -0.9F, 2.0F}})).size(),
            1U);
}

TEST(VerticalStructurePoints, AreDeskewedFirst) {
  Vector6d twist = Vector6d::Zero();
  twist[0] = 10.0;
  const Points points = {{5.2F, 0.2F, 0.0F}, {5.2F, 0.2F, 2.0F}};
  const Points vertical = vertical_points_at(sampled(points, 0.05F), twist);
  ASSERT_EQ(vertical.size(), 1U);
  EXPECT_TRUE(test::near(vertical[0], Point(5.7F, 0.2F, 2.0F), 1e-5)) << "10 m/s for 50 ms";
}

TEST(VerticalStructurePoints, AreThinnedToSomeHundred) {
  Points points = {{0.5F, 0.5F, -1.0F}};
  for (int i = 0; i < 1000; ++i) points.emplace_back(0.5F, 0.5F, 0.01F * static_cast<float>(i));
  const Points all = vertical_points_at(sampled(points), Vector6d::Zero());
  const Points some = sampled_vertical_points_at(sampled(points), Vector6d::Zero());
  ASSERT_EQ(all.size(), 1000U);
  ASSERT_EQ(some.size(), 334U) << "every third of 1000";
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i], all[3 * i]) << i;
  points.resize(300);
  EXPECT_EQ(sampled_vertical_points_at(sampled(points), Vector6d::Zero()).size(), 299U);
}

TEST(VoxelKeyFilter, NeverMissesAKeyAndSeldomReportsAnother) {
  VoxelKeyFilter filter;
  EXPECT_FALSE(filter.may_contain(voxel_key({0, 0, 0})));
  std::mt19937 engine(3);
  std::uniform_int_distribution<int> any(-500, 500);
  const auto key = [&] { return voxel_key({any(engine), any(engine), any(engine)}); };
  std::vector<VoxelKey> inserted;
  for (int i = 0; i < 2000; ++i) inserted.push_back(key());
  for (const VoxelKey k : inserted) filter.insert(k);
  for (const VoxelKey k : inserted) ASSERT_TRUE(filter.may_contain(k));
  int others = 0;
  for (int i = 0; i < 100'000; ++i) others += filter.may_contain(key()) ? 1 : 0;
  EXPECT_LT(others, 200) << "2000 of two million bits are set: one in a thousand";
}

// The map.

TEST(VerticalStructureMap, IsEmptyUntilPointsAreInserted) {
  VerticalStructureMap map;
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.count_near(pole(5.0F, 0.0F), Pose()), 0U);
  EXPECT_EQ(map.evaluate(pole(5.0F, 0.0F), Pose()).matched_points, 0U);
  map.insert({}, Pose());
  EXPECT_TRUE(map.empty());
  map.insert(pole(5.0F, 0.0F), Pose());
  EXPECT_FALSE(map.empty());
}

TEST(VerticalStructureMap, MatchesWithinThirtyCentimetresOfTheMeanOfAVoxel) {
  // Both in the voxel from 5.1 to 5.4 m, with their mean at 5.2 m.
  const VerticalStructureMap map = map_of({{5.12F, 0.15F, 0.15F}, {5.28F, 0.15F, 0.15F}});
  const auto matches = [&](float x) {
    return map.evaluate({{x, 0.15F, 0.15F}}, Pose()).matched_points == 1;
  };
  EXPECT_TRUE(matches(5.2F));
  EXPECT_TRUE(matches(5.2F + 0.29F));
  EXPECT_FALSE(matches(5.2F + 0.31F));
  EXPECT_TRUE(matches(5.2F - 0.29F));
  EXPECT_FALSE(matches(5.2F - 0.31F));
}

TEST(VerticalStructureMap, HoldsPointsAtThePoseOfTheirSensor) {
  const Pose T{exp_so3({0.0, 0.0, 2.0}), {-30.0, 12.0, 1.0}};
  const Points points = forest(1);
  const VerticalStructureMap map = map_of(points, T);
  EXPECT_EQ(map.evaluate(points, T).matched_points, points.size());
  EXPECT_EQ(map.count_near(points, T), points.size());
  EXPECT_LT(map.evaluate(points, Pose()).matched_points, points.size() / 10);
  EXPECT_TRUE(test::near(map.evaluate(points, T).T_map_sensor, T, 1e-12));
}

TEST(VerticalStructureMap, CountsOnlyFourPointsOrAnEighteenthInADirection) {
  const Points ten = pole(6.0F, 0.0F, 10);
  VerticalStructureMap::Fit fit = map_of(ten).evaluate(ten, Pose());
  EXPECT_EQ(fit.matched_points, 10U);
  EXPECT_EQ(fit.directions, 1);
  EXPECT_EQ(fit.evidence, 4);
  const Points many = pole(6.0F, 0.0F, 180);
  EXPECT_EQ(map_of(many).evaluate(many, Pose()).evidence, 180 / 18);
}

TEST(VerticalStructureMap, HasThirtySixDirectionsAroundTheSensor) {
  std::vector<double> middles;
  for (int i = 0; i < 36; ++i) middles.push_back(10.0 * i - 175.0);
  const Points points = poles(middles);
  const Pose turned{exp_so3({0.0, 0.0, 0.7}), {3.0, 0.0, 0.0}};
  const VerticalStructureMap::Fit fit = map_of(points, turned).evaluate(points, turned);
  EXPECT_EQ(fit.directions, 36);
  EXPECT_EQ(fit.evidence, 36 * 6) << "6 points on each pole, of at most 12";
  const Points behind = {{-6.0F, 0.0F, 0.15F}};  // at 180 degrees, the end of the last direction
  EXPECT_EQ(map_of(behind).evaluate(behind, Pose()).directions, 1);
}

TEST(VerticalStructureFit, ChangesOnlyPositionAndHeading) {
  const Points points = forest(2);
  const VerticalStructureMap map = map_of(points);
  Vector6d off;
  off << 0.2, -0.15, 0.05, 0.01, -0.008, 0.005;
  const Pose start = perturbed(Pose(), off);
  const Pose found = map.fit(points, start).T_map_sensor;
  const Vector6d change = difference(start, found);
  EXPECT_TRUE(test::near(change.segment<3>(2), Eigen::Vector3d::Zero(), 1e-9))
      << "height, roll and pitch";
  EXPECT_TRUE(test::near(found.translation.head<2>(), Eigen::Vector2d::Zero(), 0.05));
  EXPECT_NEAR(yaw_of(found.rotation), 0.0, 0.002);
}

TEST(VerticalStructureFit, StaysAtTheStartWhereNothingIsNear) {
  const Points points = forest(2);
  const Pose start{exp_so3({0.0, 0.0, 1.0}), {500.0, 300.0, 0.0}};
  const VerticalStructureMap::Fit fit = map_of(points).fit(points, start);
  EXPECT_TRUE(test::near(fit.T_map_sensor, start, 1e-12));
  EXPECT_EQ(fit.matched_points, 0U);
}

// The search.

TEST(HeadingOf, IsTheLevelDirectionOfADisplacement) {
  Vector6d displacement;
  displacement << 3.0, -4.0, 7.0, 0.0, 0.0, 1.0;
  EXPECT_TRUE(test::near(heading_of(displacement), Eigen::Vector2d(0.6, -0.8), 1e-12));
  displacement << 0.03, -0.04, 7.0, 0.0, 0.0, 1.0;
  EXPECT_TRUE(test::near(heading_of(displacement), Eigen::Vector2d::UnitX(), 1e-12))
      << "5 cm have no direction";
}

TEST(CoarseSearch, FindsThePoseAheadInEachOfFourDirections) {
  const Points world = forest(3);
  const VerticalStructureMap map = map_of(world);
  const Pose center{exp_so3({0.0, 0.0, 0.4}), {1.0, -2.0, 0.0}};
  for (const Eigen::Vector2d& by : {Eigen::Vector2d(5.1, 0.3), Eigen::Vector2d(-0.3, 4.2),
                                    Eigen::Vector2d(-3.9, 0.0), Eigen::Vector2d(0.6, -5.7)}) {
    const Pose truth = displaced(center, by);
    EXPECT_TRUE(test::near(coarse_search(map, seen_from(world, truth), center), truth, 0.45))
        << by.transpose();
  }
}

TEST(CoarseSearch, EndsAtSixMetres) {
  const Points world = forest(3);
  const Pose truth = displaced(Pose(), {9.0, 0.0});
  const Pose found = coarse_search(map_of(world), seen_from(world, truth), Pose());
  EXPECT_LT(found.translation.norm(), 6.1);
}

TEST(CoarseSearch, StaysWhereItBeginsIfNothingIsNear) {
  const Pose center{exp_so3({0.0, 0.0, 0.4}), {1.0, -2.0, 0.0}};
  EXPECT_TRUE(test::near(coarse_search({}, forest(1), center), center, 1e-12));
}

/// Whether a sensor in the middle of these points knows how far it is along `ahead`.
bool is_distinct_in(const Points& points, const Eigen::Vector2d& ahead = Eigen::Vector2d::UnitX()) {
  const VerticalStructureMap map = map_of(points);
  return is_distinct(map, map.evaluate(points, Pose()), ahead, points);
}

TEST(IsDistinct, NeedsStructuresInFourDirections) {
  EXPECT_TRUE(is_distinct_in(poles({15.0, 105.0, -75.0, 165.0})));
  EXPECT_FALSE(is_distinct_in(poles({15.0, 105.0, -75.0})));
  EXPECT_FALSE(is_distinct_in(poles({15.0, 18.0, 105.0, -75.0}))) << "two in one direction";
}

TEST(IsDistinct, NeedsStructuresThatEndAlongThePath) {
  Points street;
  for (int i = -60; i <= 60; ++i) {
    for (const float y : {-5.0F, 5.0F}) {
      const Points column = pole(0.3F * static_cast<float>(i) + 0.15F, y, 2);
      street.insert(street.end(), column.begin(), column.end());
    }
  }
  EXPECT_FALSE(is_distinct_in(street)) << "two walls look the same further on";
  EXPECT_TRUE(is_distinct_in(street, Eigen::Vector2d::UnitY())) << "but not further aside";
}

}  // namespace
}  // namespace lidar_mapping::front_end
