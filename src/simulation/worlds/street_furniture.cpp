// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/street_furniture.hpp"

#include <cmath>

#include "lidar_mapping/common/rotations.hpp"

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

Pose upright(const Eigen::Vector3d& at, double yaw) { return {rotation_about_z(yaw), at}; }

Eigen::Vector3d random_direction(Random& random) {
  const double z = random.normal(), y = random.normal(), x = random.normal();
  return Eigen::Vector3d(x, y, z).normalized();
}

/// A leaf cluster: a small quadrilateral of random orientation.
void add_leaf(TriangleMesh& mesh, const Eigen::Vector3d& centre, double size, Random& random) {
  const Eigen::Vector3d normal = random_direction(random);
  const Eigen::Vector3d u = 0.5 * size * normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  add_quad(mesh, centre - u - v, centre + u - v, centre + u + v, centre - u + v, kLeaf);
}

/// Leaves in an ellipsoid, denser towards its surface.
void add_crown(TriangleMesh& mesh, const Eigen::Vector3d& centre, const Eigen::Vector3d& radii,
               int leaves, Random& random) {
  for (int i = 0; i < leaves; ++i) {
    const double depth = std::pow(random.uniform(), 0.25);
    const double size = random.uniform(0.15, 0.4);
    const Eigen::Vector3d direction = random_direction(random);
    add_leaf(mesh, centre + depth * radii.cwiseProduct(direction), size, random);
  }
}

void add_hedge(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
               Random& random) {
  const double height = random.uniform(0.9, 1.9), length = (b - a).norm();
  const Eigen::Vector3d along = (b - a) / length, across(-along.y(), along.x(), 0.0);
  for (int i = static_cast<int>(length * height * 22.0); i > 0; --i) {
    const double up = random.uniform(0.0, height), aside = random.uniform(-0.3, 0.3);
    const double ahead = random.uniform(0.0, length);
    const Eigen::Vector3d at = a + ahead * along + aside * across + Eigen::Vector3d(0.0, 0.0, up);
    add_leaf(mesh, at, random.uniform(0.15, 0.3), random);
  }
}

void add_pickets(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                 Random& random) {
  const double height = random.uniform(0.8, 1.5), length = (b - a).norm();
  const double spacing = random.uniform(0.18, 0.3), yaw = std::atan2(b.y() - a.y(), b.x() - a.x());
  for (double s = 0.0; s < length; s += spacing) {
    const Eigen::Vector3d foot = a + s / length * (b - a);
    add_box(mesh, upright(foot + Eigen::Vector3d(0.0, 0.0, 0.5 * height), yaw),
            {0.07, 0.03, height}, kBark);
  }
}

}  // namespace

void add_tree(TriangleMesh& mesh, const Eigen::Vector3d& foot, double height, Random random) {
  const double trunk = random.uniform(0.3, 0.45) * height, radius = 0.02 * height;
  const double lean_y = random.uniform(-0.3, 0.3), lean_x = random.uniform(-0.3, 0.3);
  const Eigen::Vector3d lean(lean_x, lean_y, 0.0);
  const Eigen::Vector3d below(0.0, 0.0, -0.3);
  const Eigen::Vector3d fork = lean + Eigen::Vector3d(0.0, 0.0, trunk);
  add_tube(mesh, foot + below, fork - below, 1.3 * radius, radius, 8, kBark);
  const Eigen::Vector3d centre = foot + fork + Eigen::Vector3d(0.0, 0.0, 0.25 * height);
  const double spread = random.uniform(0.2, 0.32) * height;
  for (int i = random.integer(3, 6); i > 0; --i) {
    const Eigen::Vector3d tip = 0.7 * spread * random_direction(random);
    add_tube(mesh, foot + fork, centre + tip - foot - fork, 0.6 * radius, 0.2 * radius, 5, kBark);
  }
  add_crown(mesh, centre, {spread, spread, 0.38 * height}, static_cast<int>(35.0 * height), random);
}

void add_bush(TriangleMesh& mesh, const Eigen::Vector3d& foot, double height, Random random) {
  const double radius_y = random.uniform(0.5, 0.9) * height;
  const double radius_x = random.uniform(0.5, 0.9) * height;
  const Eigen::Vector3d radii(radius_x, radius_y, 0.5 * height);
  add_crown(mesh, foot + Eigen::Vector3d(0.0, 0.0, 0.5 * height), radii,
            static_cast<int>(60.0 * height * height), random);
}

void add_lamp(TriangleMesh& mesh, const Eigen::Vector3d& foot, double yaw, Random random) {
  const double height = random.uniform(5.0, 8.0), arm = random.uniform(0.6, 1.8);
  const Eigen::Vector3d top = foot + Eigen::Vector3d(0.0, 0.0, height);
  const Eigen::Vector3d ahead(std::cos(yaw), std::sin(yaw), 0.0);
  add_tube(mesh, foot, top - foot, 0.1, 0.06, 8, kSteel);
  add_tube(mesh, top, arm * ahead, 0.05, 0.05, 5, kSteel);
  add_box(mesh, upright(top + arm * ahead, yaw), {0.6, 0.25, 0.12}, kSteel);
}

void add_sign(TriangleMesh& mesh, const Eigen::Vector3d& foot, double yaw, Random random) {
  const double height = random.uniform(2.0, 2.6), size = random.uniform(0.5, 0.9);
  add_tube(mesh, foot, {0.0, 0.0, height + size}, 0.04, 0.04, 6, kSteel);
  const Eigen::Vector3d ahead(std::cos(yaw), std::sin(yaw), 0.0);
  add_box(mesh, upright(foot + 0.06 * ahead + Eigen::Vector3d(0.0, 0.0, height + 0.5 * size), yaw),
          {0.02, size, size}, kSign);
}

void add_fence(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
               Random random) {
  const double kind = random.uniform();
  if (kind < 0.4) return add_hedge(mesh, a, b, random);
  if (kind < 0.7) return add_pickets(mesh, a, b, random);
  const double height = random.uniform(0.6, 2.0);
  const Eigen::Vector3d up(0.0, 0.0, height), below(0.0, 0.0, -0.4);
  const Eigen::Vector3d across =
      0.12 * Eigen::Vector3d(a.y() - b.y(), b.x() - a.x(), 0.0).normalized();
  for (const double side : {-1.0, 1.0}) {
    add_quad(mesh, a + side * across + below, b + side * across + below, b + side * across + up,
             a + side * across + up, kConcrete);
  }
  add_quad(mesh, a - across + up, b - across + up, b + across + up, a + across + up, kConcrete);
}

void add_street_box(TriangleMesh& mesh, const Eigen::Vector3d& foot, double yaw, Random random) {
  const double size_z = random.uniform(0.7, 1.4), size_y = random.uniform(0.3, 1.2);
  const double size_x = random.uniform(0.3, 0.8);
  const Eigen::Vector3d size(size_x, size_y, size_z);
  add_box(mesh, upright(foot + Eigen::Vector3d(0.0, 0.0, 0.5 * size.z()), yaw), size,
          static_cast<Reflectivity>(random.integer(40, 200)));
}

}  // namespace lidar_mapping::simulation
