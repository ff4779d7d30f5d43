// SPDX-License-Identifier: BSD-3-Clause
// The figures of a match, on points that are placed so that each figure follows by hand.

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "decision/verification.hpp"
#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using Vector = Eigen::Vector3f;
using Points = std::vector<Vector>;

constexpr double kRange = 2.0;  // m, fitness_score_max_range

/// A submap of these points; those above 0.5 m count as above the ground.
Submap submap_of(const Points& points) {
  Submap submap;
  submap.surface = SurfaceCloud(points);
  for (const Vector& p : submap.surface.tree().points()) {
    submap.above_ground.push_back(p.z() > 0.5F);
  }
  return submap;
}

/// A scan of these points; those above 0.5 m count as above the ground.
QueryScan query_of(const Points& points) {
  QueryScan query;
  query.points = points;
  for (const Vector& p : points) query.above_ground.push_back(p.z() > 0.5F);
  return query;
}

MatchFigures figures_of(const QueryScan& query, const Submap& submap, const Pose& T = Pose()) {
  return measure_match(query, submap, T, kRange);
}

/// A wall from z = 1 to 3 m: points every 0.25 m from `from` along `direction`, which is level.
Points wall(const Vector& from, const Vector& direction, int columns) {
  Points points;
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row <= 8; ++row) {
      const float along = 0.25F * static_cast<float>(column);
      points.push_back(from + along * direction +
                       Vector(0.0F, 0.0F, 1.0F + 0.25F * static_cast<float>(row)));
    }
  }
  return points;
}

Points both(Points a, const Points& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Points of `wall(from, direction, ...)` in its middle row.
Points on_wall(const Vector& from, const Vector& direction, int first, int count) {
  Points points;
  for (int i = first; i < first + count; ++i) {
    points.push_back(from + 0.25F * static_cast<float>(i) * direction + Vector(0.0F, 0.0F, 2.0F));
  }
  return points;
}

const Vector kX = Vector::UnitX();
const Vector kY = Vector::UnitY();
const Vector kAhead(10.0F, 0.0F, 0.0F);  // where a wall begins

TEST(Overlap, CountsTestedPointsWithAPartnerWithinThirtyCentimetres) {
  const Submap submap = submap_of(wall(kAhead, kY, 20));
  Points points = on_wall(kAhead, kY, 5, 6);
  for (Vector& p : points) p.x() -= 0.29F;
  points[4].x() -= 0.02F;
  points[5].x() -= 0.02F;
  const MatchFigures figures = figures_of(query_of(points), submap);
  EXPECT_EQ(figures.tested_points, 6);
  EXPECT_DOUBLE_EQ(figures.overlap, 4.0 / 6.0);
}

// The wall is 10 m away and 1 to 3 m high. The LiDAR at the origin has seen up to a slope of 0.2.
TEST(Overlap, IsTakenWhereTheLidarOfTheSubmapCanSee) {
  Points low;
  for (const Vector& p : wall(kAhead, kY, 5)) {
    if (p.z() < 2.2F) low.push_back(p);
  }
  Submap submap = submap_of(low);
  const QueryScan query = query_of(wall(kAhead, kY, 5));
  EXPECT_EQ(figures_of(query, submap).tested_points, 45);
  // Five of nine rows are there, and one more has partners 0.25 m below.
  EXPECT_DOUBLE_EQ(figures_of(query, submap).overlap, 30.0 / 45.0);
  auto view = std::make_shared<ElevationRange>();
  view->add(low, submap.p_base_lidar);
  submap.view = view;
  EXPECT_EQ(figures_of(query, submap).tested_points, 25);
  EXPECT_DOUBLE_EQ(figures_of(query, submap).overlap, 1.0);
}

TEST(Overlap, DoesNotCountTheGroundAndPointsBeyondFortyMetres) {
  const Submap submap = submap_of(wall(kAhead, kY, 20));
  Points points = on_wall(kAhead, kY, 5, 4);
  points.emplace_back(9.0F, 0.0F, 0.2F);   // on the ground
  points.emplace_back(40.1F, 0.0F, 2.0F);  // too far away
  points.emplace_back(39.0F, 0.0F, 2.0F);  // tested, and alone
  const MatchFigures figures = figures_of(query_of(points), submap);
  EXPECT_EQ(figures.tested_points, 5);
  EXPECT_DOUBLE_EQ(figures.overlap, 4.0 / 5.0);
}

// 40 m are measured from the scan, not from the submap.
TEST(Overlap, IsThatOfTheScanAtItsPose) {
  const Submap submap = submap_of(wall({60.0F, 0.0F, 0.0F}, kX, 20));
  const Pose T_submap_query = planar(60.0, -5.0, kPi / 2.0);
  // Five metres ahead of the scan lies the wall, from right (+x of the submap) to left.
  const Points points = {{5.0F, -1.0F, 2.0F}, {5.0F, -2.0F, 2.0F}, {5.0F, 3.0F, 2.0F}};
  const MatchFigures figures = figures_of(query_of(points), submap, T_submap_query);
  EXPECT_EQ(figures.tested_points, 3);
  EXPECT_DOUBLE_EQ(figures.overlap, 2.0 / 3.0) << "the third one lies 3 m before the wall begins";
}

TEST(Overlap, OfNothingIsZero) {
  const MatchFigures nothing = figures_of({}, submap_of(wall(kAhead, kY, 20)));
  EXPECT_EQ(nothing.tested_points, 0);
  EXPECT_EQ(nothing.overlap, 0.0);
  EXPECT_EQ(nothing.horizontal_eigenvalue, 0.0);
  EXPECT_EQ(nothing.free_space_violation, 0.0);
  EXPECT_EQ(figures_of(query_of(on_wall(kAhead, kY, 0, 3)), {}).overlap, 0.0);
}

TEST(Fitness, IsTheMeanSquaredDistanceOfAllPointsWithAPartner) {
  const Submap submap = submap_of(wall(kAhead, kY, 20));
  Points points = on_wall(kAhead, kY, 5, 3);
  points[0].x() -= 0.5F;
  points[1].x() -= 1.0F;
  points[2].x() -= 2.1F;  // farther than the range
  EXPECT_NEAR(figures_of(query_of(points), submap).fitness, (0.25 + 1.0) / 2.0, 1e-6);
  // The ground counts here, too: it lies 1.5 m below the wall's lowest point.
  points[2] = {10.0F, 1.25F, -0.5F};
  EXPECT_NEAR(figures_of(query_of(points), submap).fitness, (0.25 + 1.0 + 2.25) / 3.0, 1e-6);
}

TEST(Fitness, IsTheSquaredRangeIfNothingHasAPartner) {
  const Submap submap = submap_of(wall(kAhead, kY, 20));
  EXPECT_DOUBLE_EQ(figures_of(query_of({{0.0F, 0.0F, 2.0F}}), submap).fitness, kRange * kRange);
  EXPECT_DOUBLE_EQ(figures_of({}, submap).fitness, kRange * kRange);
}

// Walls of normal n with the fraction f of the points: the smaller eigenvalue of sum f n n^T.
TEST(HorizontalEigenvalue, SaysHowWellWallsDetermineThePosition) {
  const Vector left(0.0F, 10.0F, 0.0F);
  const Submap submap = submap_of(both(wall(kAhead, kY, 30), wall(left, kX, 30)));
  const auto eigenvalue = [&](int ahead, int aside) {
    const Points points = both(on_wall(kAhead, kY, 5, ahead), on_wall(left, kX, 5, aside));
    return figures_of(query_of(points), submap).horizontal_eigenvalue;
  };
  EXPECT_NEAR(eigenvalue(10, 0), 0.0, 1e-6) << "a single wall";
  EXPECT_NEAR(eigenvalue(10, 10), 0.5, 1e-4) << "a corner";
  EXPECT_NEAR(eigenvalue(15, 5), 0.25, 1e-4);
}

TEST(HorizontalEigenvalue, DoesNotDependOnTheAxes) {
  const Vector diagonal = Vector(1.0F, 1.0F, 0.0F).normalized();
  const Submap submap = submap_of(wall(kAhead, diagonal, 30));
  const QueryScan query = query_of(on_wall(kAhead, diagonal, 5, 10));
  EXPECT_NEAR(figures_of(query, submap).horizontal_eigenvalue, 0.0, 1e-6);
}

TEST(HorizontalEigenvalue, TakesPointsBesideTheEndOfAWallButNotBeforeIt) {
  const Vector left(0.0F, 10.0F, 0.0F);
  const Submap submap = submap_of(both(wall(kAhead, kY, 30), wall(left, kX, 30)));
  Points points = both(on_wall(kAhead, kY, -2, 1), on_wall(left, kX, -2, 1));
  MatchFigures figures = figures_of(query_of(points), submap);
  EXPECT_EQ(figures.overlap, 0.0) << "half a metre beside both";
  EXPECT_NEAR(figures.horizontal_eigenvalue, 0.5, 1e-4) << "and on both planes";
  points = both(on_wall(kAhead, kY, 5, 1), on_wall(left, kX, 5, 1));
  points[0].x() -= 0.4F;
  points[1].y() -= 0.4F;
  figures = figures_of(query_of(points), submap);
  EXPECT_EQ(figures.horizontal_eigenvalue, 0.0) << "40 cm before both";
}

TEST(HorizontalEigenvalue, LeavesOutPointsWithoutANormal) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> any(0.0F, 2.0F);
  Points bush;
  for (int i = 0; i < 300; ++i)
    bush.emplace_back(any(engine), 5.0F + any(engine), 1.0F + any(engine));
  const Vector left(0.0F, 20.0F, 0.0F);
  const Submap submap = submap_of(both(both(wall(kAhead, kY, 30), wall(left, kX, 30)), bush));
  int without_normal = 0;
  Points points = both(on_wall(kAhead, kY, 5, 10), on_wall(left, kX, 5, 10));
  for (std::size_t i = 0; i < submap.surface.tree().points().size(); ++i) {
    const Vector& p = submap.surface.tree().points()[i];
    const bool in_bush = p.x() < 9.0F && p.y() < 9.0F;
    if (!in_bush || !submap.surface.normal(i).isZero()) continue;
    points.push_back(p);
    ++without_normal;
  }
  ASSERT_GT(without_normal, 100);
  const MatchFigures figures = figures_of(query_of(points), submap);
  EXPECT_DOUBLE_EQ(figures.overlap, 1.0);
  EXPECT_NEAR(figures.horizontal_eigenvalue, 0.5, 1e-4) << "of the two walls alone";
}

// Free space.

/// What a sensor at the origin sees of a round wall: all directions up to 20 degrees from level.
FreeSpaceImage round_wall(float radius) {
  Points points;
  for (float elevation = -20.0F; elevation <= 20.0F; elevation += 1.0F) {
    for (float azimuth = 0.0F; azimuth < 360.0F; azimuth += 0.75F) {
      const auto rad = static_cast<float>(kPi / 180.0);
      const float up = elevation * rad;
      const float round = azimuth * rad;
      points.push_back(radius * Vector(std::cos(up) * std::cos(round),
                                       std::cos(up) * std::sin(round), std::sin(up)));
    }
  }
  return {points, Vector::Zero()};
}

const Points kBeforeAWallAtTwentyMetres = {
    {10.0F, 0.0F, 1.0F},   // contradicts what was seen behind it
    {0.0F, -12.0F, 1.0F},  // the same
    {0.0F, 19.0F, 1.0F},   // within the margin of the wall
    {-30.0F, 0.0F, 1.0F},  // hidden by it
    {1.0F, 0.0F, 10.0F},   // where nothing was seen
};

TEST(FreeSpaceViolation, IsTheFractionOfTestedPointsInFreeSpace) {
  Submap submap;
  submap.image = round_wall(20.0F);
  const QueryScan query = query_of(kBeforeAWallAtTwentyMetres);
  EXPECT_DOUBLE_EQ(figures_of(query, submap).free_space_violation, 0.5);
}

TEST(FreeSpaceViolation, DoesNotTestTheGround) {
  Submap submap;
  submap.image = round_wall(20.0F);
  Points points = kBeforeAWallAtTwentyMetres;
  points[0].z() = 0.0F;
  EXPECT_DOUBLE_EQ(figures_of(query_of(points), submap).free_space_violation, 1.0 / 3.0);
}

TEST(FreeSpaceViolation, IsThatOfTheWorseDirection) {
  Submap submap = submap_of(kBeforeAWallAtTwentyMetres);
  QueryScan query;
  query.image = round_wall(20.0F);
  EXPECT_DOUBLE_EQ(figures_of(query, submap).free_space_violation, 0.5) << "submap against scan";
  submap.image = round_wall(20.0F);
  const Points intruder = {{5.0F, 5.0F, 1.0F}};
  query.points = intruder;
  query.above_ground = {true};
  EXPECT_DOUBLE_EQ(figures_of(query, submap).free_space_violation, 1.0) << "scan against submap";
}

// The wall of the submap is seen from the submap's own origin, whatever the pose of the scan is.
TEST(FreeSpaceViolation, BringsPointsIntoTheFrameOfTheOtherSide) {
  const Pose T_submap_query = planar(25.0, -10.0, 2.0);
  const Eigen::Isometry3f T(T_submap_query.matrix().cast<float>());
  Submap submap;
  submap.image = round_wall(20.0F);
  Points seen_by_query;
  for (const Vector& p : kBeforeAWallAtTwentyMetres) seen_by_query.push_back(T.inverse() * p);
  EXPECT_DOUBLE_EQ(figures_of(query_of(seen_by_query), submap, T_submap_query).free_space_violation,
                   0.5);
  Points seen_by_submap;
  for (const Vector& p : kBeforeAWallAtTwentyMetres) seen_by_submap.push_back(T * p);
  QueryScan query;
  query.image = round_wall(20.0F);
  EXPECT_DOUBLE_EQ(
      figures_of(query, submap_of(seen_by_submap), T_submap_query).free_space_violation, 0.5);
}

TEST(FreeSpaceViolation, TestsPointsUpToFortyMetres) {
  Submap submap;
  submap.image = round_wall(43.0F);
  const Points points = {{39.0F, 0.0F, 1.0F}, {0.0F, 42.0F, 1.0F}};
  EXPECT_DOUBLE_EQ(figures_of(query_of(points), submap).free_space_violation, 1.0)
      << "the second one would be consistent with the wall";
}

SingleView view_of(const Points& points) {
  SingleView view;
  view.points = points;
  for (const Vector& p : points) view.above_ground.push_back(p.z() > 0.5F);
  return view;
}

TEST(FreeSpaceViolation, OfTwoKeyFramesAloneIsMeasuredInBothDirections) {
  const Pose T_a_b = planar(25.0, -10.0, 2.0);
  const Eigen::Isometry3f T(T_a_b.matrix().cast<float>());
  Points seen_by_a, seen_by_b;
  for (const Vector& p : kBeforeAWallAtTwentyMetres) {
    seen_by_a.push_back(T * p);
    seen_by_b.push_back(T.inverse() * p);
  }
  SingleView before_a_wall;
  before_a_wall.image = round_wall(20.0F);
  EXPECT_DOUBLE_EQ(free_space_violation(before_a_wall, view_of(seen_by_b), T_a_b), 0.5);
  EXPECT_DOUBLE_EQ(free_space_violation(view_of(seen_by_a), before_a_wall, T_a_b), 0.5);
  EXPECT_DOUBLE_EQ(free_space_violation(view_of(seen_by_a), view_of(seen_by_b), T_a_b), 0.0)
      << "neither knows of free space";
}

// Roofs.

/// Points in a square of cells of 2 m around `middle`, 16 to a cell; `cells` along x times y.
Points level_patch(const Vector& middle, int cells_x, int cells_y) {
  const auto offset = [](int i, int cells) {
    return 0.5F * static_cast<float>(i - 2 * cells) + 0.25F;
  };
  Points points;
  for (int x = 0; x < 4 * cells_x; ++x) {
    for (int y = 0; y < 4 * cells_y; ++y) {
      points.push_back(middle + Vector(offset(x, cells_x), offset(y, cells_y), 0.0F));
    }
  }
  return points;
}

class RoofedFraction : public testing::Test {
 protected:
  static double of(const Points& roof) {
    Submap submap = submap_of(both(floor(), roof));
    submap.p_base_lidar = lidar();
    return roofed_fraction(submap);
  }
  static Vector lidar() { return {1.5F, -0.5F, 1.8F}; }
  /// All 225 cells around the LiDAR, and more of them.
  static Points floor() { return level_patch({1.5F, -0.5F, 0.0F}, 19, 19); }
  static Vector above_lidar(float height) { return lidar() + Vector(0.0F, 0.0F, height); }
};

TEST_F(RoofedFraction, IsThatOfTheCellsWithALevelSurfaceOverhead) {
  EXPECT_EQ(of({}), 0.0);
  EXPECT_DOUBLE_EQ(of(level_patch(above_lidar(1.0F), 5, 3)), 15.0 / 225.0);
  EXPECT_DOUBLE_EQ(of(level_patch(above_lidar(8.0F), 19, 19)), 1.0) << "a hall";
}

TEST_F(RoofedFraction, DoesNotTakeWhatIsLowOrSteepForARoof) {
  EXPECT_EQ(of(level_patch(above_lidar(0.4F), 5, 5)), 0.0) << "the roof of a car";
  EXPECT_EQ(of(wall(above_lidar(1.0F), kY, 30)), 0.0) << "a wall";
  Points ramp = level_patch(above_lidar(4.0F), 5, 5);
  for (Vector& p : ramp) p.z() += 0.4F * (p.x() - lidar().x());
  EXPECT_EQ(of(ramp), 0.0) << "22 degrees";
}

TEST_F(RoofedFraction, CountsOnlyOccupiedCells) {
  Submap submap = submap_of(level_patch(above_lidar(1.0F), 3, 3));
  submap.p_base_lidar = lidar();
  EXPECT_DOUBLE_EQ(roofed_fraction(submap), 1.0);
  EXPECT_EQ(roofed_fraction({}), 0.0);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
