// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/vehicles.hpp"

#include <vector>

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

using Profile = std::vector<Eigen::Vector2d>;

/// Adds a side view (x forward, z up, in order), extruded to `width`; above `waist` it is narrower
/// by `inset` on each side.
void add_body(TriangleMesh& mesh, const Profile& profile, double width, double waist, double inset,
              Reflectivity paint) {
  const auto at = [&](const Eigen::Vector2d& p, double side) -> Eigen::Vector3d {
    const double half = 0.5 * width - (p.y() > waist ? inset : 0.0);
    return {p.x(), side * half, p.y()};
  };
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : profile) centre += p / static_cast<double>(profile.size());
  centre.y() = waist - 0.01;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Eigen::Vector2d &a = profile[i], &b = profile[(i + 1) % profile.size()];
    const bool window = a.y() > waist - 0.05 && b.y() > waist - 0.05 && a.y() != b.y();
    add_quad(mesh, at(a, -1.0), at(a, 1.0), at(b, 1.0), at(b, -1.0), window ? kGlass : paint);
    for (const double side : {-1.0, 1.0}) {
      add_triangle(mesh, at(centre, side), at(a, side), at(b, side), paint);
    }
  }
}

void add_wheels(TriangleMesh& mesh, double front, double rear, double width, double radius) {
  for (const double x : {front, rear}) {
    for (const double side : {-1.0, 1.0}) {
      add_tube(mesh, {x, side * (0.5 * width - 0.2), radius}, {0.0, side * 0.22, 0.0}, radius,
               radius, 12, kTyre);
    }
  }
}

}  // namespace

TriangleMesh make_car(Random random) {
  TriangleMesh mesh;
  const double length = random.uniform(3.9, 4.8), width = random.uniform(1.68, 1.86);
  const double roof = random.uniform(1.4, 1.62), waist = random.uniform(0.88, 1.0);
  const double front = 0.5 * length, rear = -front;
  const bool saloon = random.chance(0.4);
  const auto paint = static_cast<Reflectivity>(random.integer(25, 190));
  const Profile profile = {{rear + 0.05, 0.25},
                           {front - 0.05, 0.25},
                           {front, 0.6},
                           {front - 0.15, waist - 0.2},
                           {front - 0.27 * length, waist},
                           {front - 0.42 * length, roof},
                           {rear + (saloon ? 0.28 : 0.13) * length, roof - 0.03},
                           {rear + (saloon ? 0.15 : 0.02) * length, waist},
                           {rear, waist - 0.1}};
  add_body(mesh, profile, width, waist, 0.15, paint);
  add_wheels(mesh, front - 0.19 * length, rear + 0.19 * length, width, 0.31);
  return mesh;
}

TriangleMesh make_van(Random random) {
  TriangleMesh mesh;
  const double length = random.uniform(4.9, 6.4), width = random.uniform(1.9, 2.05);
  const double roof = random.uniform(1.95, 2.7), waist = 1.1;
  const double front = 0.5 * length, rear = -front;
  const auto paint = static_cast<Reflectivity>(random.integer(60, 210));
  const Profile profile = {{rear, 0.3},         {front - 0.05, 0.3},  {front, 0.7},
                           {front - 0.1, 1.0},  {front - 0.75, 1.15}, {front - 1.4, roof - 0.1},
                           {front - 1.7, roof}, {rear + 0.05, roof}};
  add_body(mesh, profile, width, waist, 0.06, paint);
  add_wheels(mesh, front - 0.95, rear + 0.95, width, 0.34);
  return mesh;
}

TriangleMesh make_pedestrian(Random random) {
  TriangleMesh mesh;
  const double height = random.uniform(1.55, 1.9), stride = random.uniform(0.1, 0.3);
  const auto cloth = static_cast<Reflectivity>(random.integer(30, 150));
  const double hip = 0.5 * height;
  for (const double side : {-1.0, 1.0}) {
    add_tube(mesh, {side * stride, side * 0.09, 0.0}, {-side * stride, 0.0, hip}, 0.07, 0.09, 6,
             cloth);
  }
  add_tube(mesh, {0.0, 0.0, hip}, {0.0, 0.0, 0.35 * height}, 0.17, 0.22, 8, cloth);
  add_box(mesh, Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.93 * height}},
          {0.19, 0.16, 0.14 * height}, kCloth);
  return mesh;
}

}  // namespace lidar_mapping::simulation
