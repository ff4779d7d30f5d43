// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/mesh.hpp"

#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

using test::near;

Eigen::Vector3d vertex(const TriangleMesh& mesh, std::size_t triangle, std::size_t corner) {
  return mesh.vertices[mesh.triangles[triangle][corner]].cast<double>();
}

double area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d a = vertex(mesh, t, 0);
    sum += 0.5 * (vertex(mesh, t, 1) - a).cross(vertex(mesh, t, 2) - a).norm();
  }
  return sum;
}

/// Lower corner and upper corner.
std::pair<Eigen::Vector3d, Eigen::Vector3d> bounds(const TriangleMesh& mesh) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    low = low.cwiseMin(v.cast<double>());
    high = high.cwiseMax(v.cast<double>());
  }
  return {low, high};
}

TEST(Mesh, HasTrianglesWithTheirReflectivities) {
  TriangleMesh mesh;
  add_triangle(mesh, {0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {0.0, 3.0, 0.0}, 7);
  add_triangle(mesh, {0.0, 0.0, 1.0}, {1.0, 0.0, 1.0}, {0.0, 1.0, 1.0}, 9);
  ASSERT_EQ(mesh.triangles.size(), 2U);
  ASSERT_EQ(mesh.reflectivity.size(), 2U);
  EXPECT_EQ(mesh.reflectivity[0], 7);
  EXPECT_EQ(mesh.reflectivity[1], 9);
  EXPECT_TRUE(near(vertex(mesh, 1, 1), Eigen::Vector3d(1.0, 0.0, 1.0), 1e-6));
  EXPECT_NEAR(area(mesh), 3.0 + 0.5, 1e-6);
}

TEST(Mesh, QuadsAreTwoTrianglesWithoutGapOrOverlap) {
  TriangleMesh mesh;
  add_quad(mesh, {0.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, {3.0, 2.0, 0.0}, {1.0, 2.0, 0.0}, 5);
  EXPECT_EQ(mesh.triangles.size(), 2U);
  EXPECT_EQ(mesh.reflectivity.size(), 2U);
  EXPECT_NEAR(area(mesh), 0.5 * (4.0 + 2.0) * 2.0, 1e-6) << "of the trapezium";
}

/// Every edge of a closed surface belongs to an even number of triangles; quads do not share
/// vertices, so places are compared.
void expect_closed(const TriangleMesh& mesh) {
  using Place = std::array<long, 3>;
  std::map<std::pair<Place, Place>, int> edges;
  const auto place = [&](std::size_t t, std::size_t corner) {
    const Eigen::Vector3d v = 1000.0 * vertex(mesh, t, corner);
    return Place{std::lround(v.x()), std::lround(v.y()), std::lround(v.z())};
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Place a = place(t, corner), b = place(t, (corner + 1) % 3);
      ++edges[std::minmax(a, b)];
    }
  }
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 2);
}

TEST(Mesh, BoxesAreClosedAndHaveTheirSize) {
  TriangleMesh mesh;
  add_box(mesh, {Eigen::Quaterniond::Identity(), {1.0, 2.0, 3.0}}, {2.0, 4.0, 6.0}, 1);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_NEAR(area(mesh), 2.0 * (8.0 + 12.0 + 24.0), 1e-4);
  EXPECT_TRUE(near(bounds(mesh).first, Eigen::Vector3d(0.0, 0.0, 0.0), 1e-5));
  EXPECT_TRUE(near(bounds(mesh).second, Eigen::Vector3d(2.0, 4.0, 6.0), 1e-5));
  expect_closed(mesh);
}

TEST(Mesh, BoxesStandAtTheirPose) {
  TriangleMesh mesh;
  add_box(mesh, {exp_so3({0.0, 0.0, 0.5 * kPi}), {10.0, 0.0, 0.0}}, {2.0, 4.0, 6.0}, 1);
  EXPECT_TRUE(near(bounds(mesh).first, Eigen::Vector3d(8.0, -1.0, -3.0), 1e-5));
  EXPECT_TRUE(near(bounds(mesh).second, Eigen::Vector3d(12.0, 1.0, 3.0), 1e-5));
}

TEST(Mesh, BlocksLieBetweenTheirCorners) {
  TriangleMesh mesh;
  add_block(mesh, {-1.0, 2.0, 0.5}, {3.0, 5.0, 1.0}, 1);
  EXPECT_TRUE(near(bounds(mesh).first, Eigen::Vector3d(-1.0, 2.0, 0.5), 1e-5));
  EXPECT_TRUE(near(bounds(mesh).second, Eigen::Vector3d(3.0, 5.0, 1.0), 1e-5));
  expect_closed(mesh);
}

// A cone's frustum of many sides has nearly the area of the round one: pi (R + r) s.
TEST(Mesh, TubesGoFromFootToTop) {
  const Eigen::Vector3d foot(1.0, 2.0, 3.0), axis(0.0, 3.0, 4.0);
  TriangleMesh mesh;
  add_tube(mesh, foot, axis, 0.5, 0.2, 200, 3);
  EXPECT_EQ(mesh.triangles.size(), 400U);
  EXPECT_EQ(mesh.reflectivity.size(), 400U);
  EXPECT_NEAR(area(mesh), kPi * 0.7 * std::hypot(5.0, 0.3), 1e-2);
  const Eigen::Vector3d direction = axis.normalized();
  for (const Eigen::Vector3f& v : mesh.vertices) {
    const Eigen::Vector3d from_foot = v.cast<double>() - foot;
    const double along = from_foot.dot(direction);
    const double radius = (from_foot - along * direction).norm();
    const bool is_foot = along < 2.5;
    EXPECT_NEAR(along, is_foot ? 0.0 : 5.0, 1e-5);
    EXPECT_NEAR(radius, is_foot ? 0.5 : 0.2, 1e-5);
  }
}

TEST(Mesh, AppendsOthersAtTheirPoses) {
  TriangleMesh post, mesh;
  add_block(post, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 4);
  add_triangle(mesh, {0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {0.0, 3.0, 0.0}, 7);
  append(mesh, post, {exp_so3({0.0, 0.0, kPi}), {5.0, 0.0, 2.0}});
  append(mesh, post, {Eigen::Quaterniond::Identity(), {0.0, 0.0, -9.0}});
  ASSERT_EQ(mesh.triangles.size(), 1U + 2U * 12U);
  ASSERT_EQ(mesh.reflectivity.size(), mesh.triangles.size());
  EXPECT_EQ(mesh.reflectivity[0], 7);
  EXPECT_EQ(mesh.reflectivity[1], 4);
  EXPECT_NEAR(area(mesh), 3.0 + 2.0 * 6.0, 1e-5) << "triangles have their own vertices";
  for (std::size_t t = 1; t <= 12; ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3d v = vertex(mesh, t, corner);
      EXPECT_TRUE(near(v, Eigen::Vector3d(4.5, -0.5, 2.5), 0.867)) << "the cube is turned";
    }
  }
  EXPECT_TRUE(near(bounds(mesh).first, Eigen::Vector3d(0.0, -1.0, -9.0), 1e-5));
}

}  // namespace
}  // namespace lidar_mapping::simulation
