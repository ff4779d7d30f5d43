// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "matching/point_to_plane.hpp"
#include "near.hpp"

namespace lidar_mapping::loop_closing {
namespace {

using lidar_mapping::test::near;
using Points = std::vector<Eigen::Vector3f>;

/// A yard 24 m by 16 m between houses, with a shed in it: random places on its floor and walls, 1
/// cm beside them.
Points yard(unsigned seed, int count = 6000) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  Points points;
  for (int i = 0; i < count; ++i) {
    const double a = unit(engine), b = unit(engine);
    Eigen::Vector3d p;
    switch (i % 6) {
      case 0:
        p = {24.0 * a - 12.0, 16.0 * b - 8.0, 0.0};
        break;
      case 1:
        p = {-12.0, 16.0 * a - 8.0, 7.0 * b};
        break;
      case 2:
        p = {24.0 * a - 12.0, 8.0, 7.0 * b};
        break;
      case 3:
        p = {24.0 * a - 12.0, -8.0, 7.0 * b};
        break;
      case 4:
        p = {12.0, 16.0 * a - 8.0, 7.0 * b};
        break;
      default:
        p = {-6.0, 3.0 * a - 4.0, 3.0 * b};
    }
    p += Eigen::Vector3d(noise(engine), noise(engine), noise(engine));
    points.push_back(p.cast<float>());
  }
  return points;
}

Points transformed(Points points, const Pose& T) {
  for (Eigen::Vector3f& p : points) p = (T * p.cast<double>()).cast<float>();
  return points;
}

Pose offset(double x, double y, double z, double yaw_deg) {
  return {exp_so3({0.0, 0.0, yaw_deg * M_PI / 180.0}), {x, y, z}};
}

const Pose& truth() {
  static const Pose T{exp_so3({0.02, -0.03, 0.7}), {1.2, -0.6, 0.3}};
  return T;
}

TEST(PointToPlane, ConvergesFromTwoMetresAndFiveDegrees) {
  const SurfaceCloud target(yard(1));
  const Points source = transformed(yard(2), truth().inverse());
  for (const Pose& error : {offset(2.0, 0.0, 0.0, 0.0), offset(-1.2, 1.2, 0.5, -5.0),
                            offset(0.0, 0.0, 0.0, 5.0), offset(0.0, 0.0, 0.0, 0.0)}) {
    const Alignment alignment = align_point_to_plane(source, target, truth() * error);
    EXPECT_TRUE(alignment.converged);
    EXPECT_TRUE(near(alignment.T_target_source, truth(), 0.01, 0.001));
    EXPECT_TRUE(is_valid_covariance(alignment.covariance));
  }
}

// What the two clouds have in common decides, not where the target's axes are.
TEST(PointToPlane, MovesWithTheTarget) {
  const Points target = yard(1);
  const Points source = transformed(yard(2), truth().inverse());
  const Pose guess = truth() * offset(0.5, -0.3, 0.1, 2.0);
  const Pose moved{exp_so3({0.3, 0.2, 2.1}), {50.0, -30.0, 7.0}};
  const Alignment here = align_point_to_plane(source, SurfaceCloud(target), guess);
  const Alignment there =
      align_point_to_plane(source, SurfaceCloud(transformed(target, moved)), moved * guess);
  EXPECT_TRUE(near(there.T_target_source, moved * here.T_target_source, 0.003, 0.0005));
  // In the axes of the source; where the cells of surfaces begin in the target has some effect.
  for (int i = 0; i < 6; ++i) {
    const double ratio = there.covariance(i, i) / here.covariance(i, i);
    EXPECT_GT(ratio, 0.1) << i;
    EXPECT_LT(ratio, 10.0) << i;
  }
}

TEST(PointToPlane, GivesTheSameBitsAgain) {
  const SurfaceCloud target(yard(1));
  const Points source = transformed(yard(2), truth().inverse());
  const Alignment first = align_point_to_plane(source, target, truth() * offset(0.5, 0, 0, 1.0));
  const Alignment again = align_point_to_plane(source, target, truth() * offset(0.5, 0, 0, 1.0));
  EXPECT_EQ(first.T_target_source.translation, again.T_target_source.translation);
  EXPECT_EQ(first.T_target_source.rotation.coeffs(), again.T_target_source.rotation.coeffs());
  EXPECT_EQ(first.covariance, again.covariance);
}

// People and vehicles that were not there before.
TEST(PointToPlane, IsNotLedAstrayByOtherObjects) {
  const SurfaceCloud target(yard(1));
  Points source = yard(2);
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> x(2.0F, 6.0F), y(4.5F, 7.2F), z(0.2F, 2.0F);
  for (int i = 0; i < 1500; ++i) {
    const float ahead = x(engine);
    source.emplace_back(ahead, y(engine), z(engine));
  }
  source = transformed(source, truth().inverse());
  const Alignment alignment =
      align_point_to_plane(source, target, truth() * offset(0.5, 0.5, 0.0, 2.0));
  EXPECT_TRUE(alignment.converged);
  EXPECT_TRUE(near(alignment.T_target_source, truth(), 0.03, 0.006));
}

TEST(PointToPlane, StaysWhereItBeganWithoutEnoughPairs) {
  const Pose guess = offset(0.3, 0.2, 0.1, 3.0);
  const Points few = yard(2, 29);
  for (const Points& source : {Points(), few, transformed(yard(2), offset(500, 0, 0, 0))}) {
    const SurfaceCloud target(yard(1));
    const Alignment alignment = align_point_to_plane(source, target, guess);
    EXPECT_FALSE(alignment.converged);
    EXPECT_TRUE(near(alignment.T_target_source, guess, 1e-9));
    EXPECT_FALSE(point_to_plane_covariance(source, target, guess).has_value());
  }
  EXPECT_FALSE(align_point_to_plane(yard(2), SurfaceCloud(), guess).converged);
}

// On an even field nothing tells the position along it.
TEST(PointToPlane, LeavesWhatNoSurfaceDetermines) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> place(-12.0F, 12.0F);
  Points fields[2];
  for (Points& field : fields) {
    for (int i = 0; i < 3000; ++i) {
      const float x = place(engine);
      field.emplace_back(x, place(engine), 0.0F);
    }
  }
  const Pose guess = offset(0.4, -0.3, 0.2, 3.0);
  const Alignment alignment = align_point_to_plane(fields[1], SurfaceCloud(fields[0]), guess);
  EXPECT_TRUE(near(alignment.T_target_source, offset(0.4, -0.3, 0.0, 3.0), 1e-3))
      << "the height is determined";
  for (const int unknown : {0, 1, 5}) {
    EXPECT_NEAR(std::sqrt(alignment.covariance(unknown, unknown)), 1000.0, 1.0) << unknown;
  }
  EXPECT_LT(alignment.covariance(2, 2), 0.01 * 0.01);
  EXPECT_LT(alignment.covariance(3, 3), 0.001 * 0.001);
}

TEST(PointToPlaneCovariance, IsThatOfTheAlignmentAtItsEnd) {
  const SurfaceCloud target(yard(1));
  const Points source = transformed(yard(2), truth().inverse());
  const Alignment alignment = align_point_to_plane(source, target, truth());
  const auto covariance = point_to_plane_covariance(source, target, alignment.T_target_source);
  ASSERT_TRUE(covariance.has_value());
  EXPECT_TRUE(near(*covariance, alignment.covariance, 0.1 * alignment.covariance.norm()));
}

// Without the walls across it and the shed, the yard is a passage.
TEST(PointToPlaneCovariance, GrowsAlongAPassage) {
  const auto passage = [](unsigned seed) {
    Points points;
    for (const Eigen::Vector3f& p : yard(seed)) {
      const float from_walls = std::abs(std::abs(p.x()) - 12.0F);
      if (from_walls > 0.2F && std::abs(p.x() + 6.0F) > 0.2F) points.push_back(p);
    }
    return points;
  };
  const auto along_and_across = [](const Points& source, const Points& target) {
    const auto covariance = point_to_plane_covariance(source, SurfaceCloud(target), Pose());
    return Eigen::Vector2d(covariance.value()(0, 0), covariance.value()(1, 1));
  };
  const Eigen::Vector2d in_yard = along_and_across(yard(2), yard(1));
  const Eigen::Vector2d in_passage = along_and_across(passage(2), passage(1));
  EXPECT_GT(in_passage[0], 50.0 * in_yard[0]);
  EXPECT_LT(in_passage[1], 2.0 * in_yard[1]);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing
