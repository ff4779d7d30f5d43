// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "matching/surface.hpp"
#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

TEST(SurfaceCloud, HasNormalsOnWallsAndNotInFoliage) {
  std::vector<Eigen::Vector3f> points;
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> coordinate(0.0F, 5.0F);
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(coordinate(generator), 0.0F, coordinate(generator));
    points.emplace_back(coordinate(generator), 20.0F + coordinate(generator),
                        coordinate(generator));
  }
  const SurfaceCloud surface(points);
  const auto& placed = surface.tree().points();
  int on_wall = 0;
  int in_foliage = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const bool wall = placed[i].y() < 10.0F;
    if (wall) on_wall += std::abs(surface.normal(i).y()) > 0.999F;
    if (!wall) in_foliage += !surface.normal(i).isZero();
  }
  EXPECT_EQ(on_wall, 2000);
  EXPECT_LT(in_foliage, 300);
}

// Planes of different thickness and direction, compared with a general eigenvalue solver.
TEST(SurfaceCloud, NormalsAreTheSmallestPrincipalAxes) {
  std::mt19937 generator(2);
  std::normal_distribution<float> normal;
  int planes = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3f axis =
        Eigen::Vector3f(normal(generator), normal(generator), normal(generator)).normalized();
    const float thickness = 0.002F * static_cast<float>(i);
    std::vector<Eigen::Vector3f> points;
    for (int k = 0; k < 10; ++k) {
      const Eigen::Vector3f p(normal(generator), normal(generator), normal(generator));
      points.emplace_back(50.0F * axis + p - (1.0F - thickness) * axis.dot(p) * axis);
    }
    const SurfaceCloud surface(points);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : points) mean += p.cast<double>() / 10.0;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& p : points) {
      const Eigen::Vector3d d = p.cast<double>() - mean;
      scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
    const double planarity = solver.eigenvalues()[0] / solver.eigenvalues()[1];
    if (std::abs(planarity - 0.08) < 1e-3) continue;
    ASSERT_EQ(surface.normal(0).isZero(), planarity > 0.08) << planarity;
    if (planarity > 0.08) continue;
    ++planes;
    const Eigen::Vector3d expected = solver.eigenvectors().col(0);
    EXPECT_NEAR(std::abs(surface.normal(0).cast<double>().dot(expected)), 1.0, 1e-5) << planarity;
  }
  EXPECT_GT(planes, 50);
}

TEST(SurfaceCloud, AcceptsPointsOnALineAndEqualPoints) {
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 10; ++i) line.emplace_back(0.3F * static_cast<float>(i), 5.0F, 1.0F);
  EXPECT_TRUE(SurfaceCloud(line).normal(0).allFinite());
  const std::vector<Eigen::Vector3f> equal_points(10, Eigen::Vector3f(3.0F, 2.0F, 1.0F));
  EXPECT_TRUE(SurfaceCloud(equal_points).normal(0).isZero());
}

TEST(AboveGround, FollowsASlope) {
  std::vector<Eigen::Vector3f> points;
  for (float x = -30.0F; x < 30.0F; x += 0.5F) points.emplace_back(x, 0.0F, 0.1F * x);
  const std::size_t ground = points.size();
  points.emplace_back(20.0F, 0.0F, 2.0F + 2.0F);
  const auto above = above_ground(points);
  EXPECT_TRUE(above.back());
  for (std::size_t i = 0; i < ground; ++i) EXPECT_FALSE(above[i]) << i;
}

TEST(Positions, ExcludePointsThatAreNotFinite) {
  PointCloud cloud;
  cloud.points = {{1.0F, 2.0F, 3.0F, 0.0F}, {std::nanf(""), 0.0F, 0.0F, 0.0F}};
  EXPECT_EQ(positions(cloud).size(), 1U);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
