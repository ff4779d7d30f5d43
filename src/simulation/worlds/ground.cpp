// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/ground.hpp"

#include <algorithm>
#include <cmath>

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Edge length, m; chosen: smaller ones follow slopes better and slow the rays.
constexpr double kPavementCell = 2.5;

int cells_of(double length, double cell) {
  return std::max(1, static_cast<int>(std::ceil(length / cell)));
}

}  // namespace

void add_ground(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, double cell, Reflectivity reflectivity) {
  const int nx = cells_of(high.x() - low.x(), cell), ny = cells_of(high.y() - low.y(), cell);
  const auto at = [&](int i, int j) -> Eigen::Vector3d {
    return terrain.on_ground(low + Eigen::Vector2d(i * cell, j * cell));
  };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), reflectivity);
    }
  }
}

void add_pavement(TriangleMesh& mesh, const Terrain& terrain,
                  const std::array<Eigen::Vector2d, 4>& corners, double height) {
  const int nu = cells_of((corners[1] - corners[0]).norm(), kPavementCell);
  const int nv = cells_of((corners[3] - corners[0]).norm(), kPavementCell);
  const auto plan = [&](int i, int j) -> Eigen::Vector2d {
    const double u = static_cast<double>(i) / nu, v = static_cast<double>(j) / nv;
    return (1.0 - v) * ((1.0 - u) * corners[0] + u * corners[1]) +
           v * ((1.0 - u) * corners[3] + u * corners[2]);
  };
  const auto top = [&](int i, int j) { return terrain.on_ground(plan(i, j), height); };
  const auto rim = [&](int i0, int j0, int i1, int j1) {
    add_quad(mesh, top(i0, j0), top(i1, j1), terrain.on_ground(plan(i1, j1), -0.1),
             terrain.on_ground(plan(i0, j0), -0.1), kKerbStone);
  };
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      add_quad(mesh, top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1), kPavement);
    }
    rim(0, j, 0, j + 1);
    rim(nu, j, nu, j + 1);
  }
  for (int i = 0; i < nu; ++i) {
    rim(i, 0, i + 1, 0);
    rim(i, nv, i + 1, nv);
  }
}

Pose on_slope(const Terrain& terrain, const Eigen::Vector2d& at, double yaw) {
  const Eigen::Vector2d gradient = terrain.gradient(at);
  const Eigen::Vector3d up = Eigen::Vector3d(-gradient.x(), -gradient.y(), 1.0).normalized();
  const Eigen::Vector3d left = up.cross(Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.0));
  Eigen::Matrix3d axes;
  axes.col(1) = left.normalized();
  axes.col(0) = axes.col(1).cross(up);
  axes.col(2) = up;
  return {Eigen::Quaterniond(axes).normalized(), terrain.on_ground(at)};
}

}  // namespace lidar_mapping::simulation
