// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/mesh.hpp"

#include <cmath>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::simulation {

namespace {

std::uint32_t add_vertex(TriangleMesh& mesh, const Eigen::Vector3d& vertex) {
  mesh.vertices.push_back(vertex.cast<float>());
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

}  // namespace

void add_triangle(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c, Reflectivity reflectivity) {
  mesh.triangles.push_back({add_vertex(mesh, a), add_vertex(mesh, b), add_vertex(mesh, c)});
  mesh.reflectivity.push_back(reflectivity);
}

void add_quad(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
              const Eigen::Vector3d& c, const Eigen::Vector3d& d, Reflectivity reflectivity) {
  const std::uint32_t first = add_vertex(mesh, a);
  add_vertex(mesh, b);
  add_vertex(mesh, c);
  add_vertex(mesh, d);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  mesh.reflectivity.insert(mesh.reflectivity.end(), 2, reflectivity);
}

void add_box(TriangleMesh& mesh, const Pose& T_mesh_box, const Eigen::Vector3d& size,
             Reflectivity reflectivity) {
  const auto corner = [&](int i) -> Eigen::Vector3d {
    const Eigen::Vector3d signs((i & 1) ? 0.5 : -0.5, (i & 2) ? 0.5 : -0.5, (i & 4) ? 0.5 : -0.5);
    return T_mesh_box * signs.cwiseProduct(size);
  };
  constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (const auto& face : kFaces) {
    add_quad(mesh, corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3]),
             reflectivity);
  }
}

void add_block(TriangleMesh& mesh, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
               Reflectivity reflectivity) {
  add_box(mesh, Pose{Eigen::Quaterniond::Identity(), 0.5 * (low + high)}, high - low, reflectivity);
}

void add_tube(TriangleMesh& mesh, const Eigen::Vector3d& foot, const Eigen::Vector3d& axis,
              double foot_radius, double top_radius, int sides, Reflectivity reflectivity) {
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.normalized().cross(u);
  const auto rim = [&](int i) -> Eigen::Vector3d {
    const double angle = 2.0 * kPi * i / sides;
    return std::cos(angle) * u + std::sin(angle) * v;
  };
  for (int i = 0; i < sides; ++i) {
    const Eigen::Vector3d a = rim(i), b = rim(i + 1);
    add_quad(mesh, foot + foot_radius * a, foot + foot_radius * b, foot + axis + top_radius * b,
             foot + axis + top_radius * a, reflectivity);
  }
}

void append(TriangleMesh& mesh, const TriangleMesh& other, const Pose& T_mesh_other) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Eigen::Vector3f& vertex : other.vertices) {
    mesh.vertices.push_back((T_mesh_other * vertex.cast<double>()).cast<float>());
  }
  for (const auto& t : other.triangles) {
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  mesh.reflectivity.insert(mesh.reflectivity.end(), other.reflectivity.begin(),
                           other.reflectivity.end());
}

}  // namespace lidar_mapping::simulation
