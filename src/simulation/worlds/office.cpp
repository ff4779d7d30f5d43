// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/office.hpp"

#include <array>
#include <cmath>

#include "lidar_mapping/common/rotations.hpp"

namespace lidar_mapping::simulation {

namespace {

// Dimensions, chosen as in usual office buildings.
constexpr double kRoomWidth = 6.0;   ///< m
constexpr double kCeiling = 2.8;     ///< m
constexpr double kDoor = 0.5;        ///< Half width of a door, m.
constexpr double kDoorHeight = 2.1;  ///< m
constexpr double kWall = 0.12;       ///< Thickness, m.

/// Adds a wall between two points, with or without a door in its middle.
void add_wall(TriangleMesh& mesh, const Eigen::Vector2d& a, const Eigen::Vector2d& b, bool door,
              Reflectivity paint) {
  const Eigen::Vector2d along = (b - a).normalized(), middle = 0.5 * (a + b);
  const double yaw = std::atan2(along.y(), along.x());
  const auto piece = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, double low,
                         double high) {
    const Eigen::Vector2d centre = 0.5 * (from + to);
    add_box(mesh, {rotation_about_z(yaw), {centre.x(), centre.y(), 0.5 * (low + high)}},
            {(to - from).norm(), kWall, high - low}, paint);
  };
  if (!door) return piece(a, b, 0.0, kCeiling);
  const Eigen::Vector2d left = middle - kDoor * along, right = middle + kDoor * along;
  piece(a, left, 0.0, kCeiling);
  piece(right, b, 0.0, kCeiling);
  piece(left, right, kDoorHeight, kCeiling);
}

void add_furniture(TriangleMesh& mesh, const Eigen::Vector2d& wall, const Eigen::Vector2d& along,
                   const Eigen::Vector2d& inwards, Random& random) {
  const double yaw = std::atan2(along.y(), along.x());
  const auto add_piece = [&](double s, double in, const Eigen::Vector3d& size, double foot) {
    const Eigen::Vector2d at = wall + s * along + in * inwards;
    add_box(mesh, {rotation_about_z(yaw), {at.x(), at.y(), foot + 0.5 * size.z()}}, size,
            static_cast<Reflectivity>(random.integer(40, 190)));
  };
  // Shelves and tables stand at the outer wall and in the corners, away from the path.
  const double outer = kOfficeRoomDepth - 0.35;
  const Eigen::Vector3d shelf{random.uniform(0.8, 1.8), 0.45, random.uniform(0.8, 2.1)};
  add_piece(random.uniform(-2.0, -1.0), outer, shelf, 0.0);
  const Eigen::Vector3d table{random.uniform(0.8, 1.6), 0.5, 0.06};
  add_piece(random.uniform(1.0, 2.0), outer, table, 0.74);
  add_piece(random.uniform(0.6, 1.9), outer - 0.1, {0.4, 0.2, 0.4}, 0.8);
  const Eigen::Vector3d before{0.5, random.uniform(0.6, 1.0), random.uniform(0.7, 1.9)};
  add_piece(-2.55, random.uniform(0.6, 1.3), before, 0.0);
  const Eigen::Vector3d behind{0.5, random.uniform(0.5, 1.0), random.uniform(0.4, 1.2)};
  add_piece(2.55, random.uniform(0.6, 1.3), behind, 0.0);
}

/// Adds a row of rooms along a side of the ring. `begin` lies on the outer wall of the corridor.
void add_rooms(TriangleMesh& mesh, const Eigen::Vector2d& begin, const Eigen::Vector2d& along,
               double length, Random& random) {
  const Eigen::Vector2d inwards(along.y(), -along.x());
  const int rooms = static_cast<int>(std::lround(length / kRoomWidth));
  for (int i = 0; i < rooms; ++i) {
    const Eigen::Vector2d a = begin + i * kRoomWidth * along, b = a + kRoomWidth * along;
    const auto paint = static_cast<Reflectivity>(random.integer(110, 210));
    add_wall(mesh, a, b, true, paint);
    add_wall(mesh, a, a + kOfficeRoomDepth * inwards, false, paint);
    add_wall(mesh, a + kOfficeRoomDepth * inwards, b + kOfficeRoomDepth * inwards, false, paint);
    if (i + 1 == rooms) add_wall(mesh, b, b + kOfficeRoomDepth * inwards, false, paint);
    add_furniture(mesh, 0.5 * (a + b), along, inwards, random);
  }
}

/// Adds cupboards, plants and pipes along the core, so that the corridors differ.
void add_corridor_furniture(TriangleMesh& mesh, Random& random) {
  const double x1 = kOfficeLength - kOfficeCorridor, y1 = kOfficeWidth - kOfficeCorridor;
  for (double x = 3.0; x < x1 - 1.0; x += random.uniform(2.5, 6.0)) {
    for (const double y : {kOfficeCorridor - 0.12, y1 + 0.12}) {
      const double height = random.uniform(0.4, 2.0), length = random.uniform(0.3, 1.2);
      if (random.chance(0.4)) continue;
      add_box(mesh, Pose{Eigen::Quaterniond::Identity(), {x, y, 0.5 * height}},
              {length, 0.3, height}, static_cast<Reflectivity>(random.integer(40, 190)));
    }
  }
}

}  // namespace

void add_office(TriangleMesh& mesh, Random random) {
  const double l = kOfficeLength, w = kOfficeWidth, c = kOfficeCorridor, out = c + kOfficeRoomDepth;
  for (const double z : {0.0, kCeiling}) {
    add_quad(mesh, {-out, -out, z}, {l + out, -out, z}, {l + out, w + out, z}, {-out, w + out, z},
             z > 0.0 ? Reflectivity{190} : Reflectivity{75});
  }
  const std::array<Eigen::Vector2d, 4> core = {
      Eigen::Vector2d{c, c}, {l - c, c}, {l - c, w - c}, {c, w - c}};
  for (int i = 0; i < 4; ++i) add_wall(mesh, core[i], core[(i + 1) % 4], false, 150);
  add_rooms(mesh, {0.0, -c}, {1.0, 0.0}, l, random);
  add_rooms(mesh, {l + c, -0.0}, {0.0, 1.0}, 12.0, random);
  add_rooms(mesh, {l, w + c}, {-1.0, 0.0}, l, random);
  add_rooms(mesh, {-c, w}, {0.0, -1.0}, 12.0, random);
  // Closes the corners that the rows of rooms leave open.
  add_wall(mesh, {-c, w - 12.0}, {-c, -c}, false, 160);
  add_wall(mesh, {-c, -c}, {0.0, -c}, false, 160);
  add_wall(mesh, {l, -c}, {l + c, -c}, false, 160);
  add_wall(mesh, {l + c, -c}, {l + c, 0.0}, false, 160);
  add_wall(mesh, {l + c, 12.0}, {l + c, w + c}, false, 160);
  add_wall(mesh, {l + c, w + c}, {l, w + c}, false, 160);
  add_wall(mesh, {0.0, w + c}, {-c, w + c}, false, 160);
  add_wall(mesh, {-c, w + c}, {-c, w}, false, 160);
  add_corridor_furniture(mesh, random);
}

}  // namespace lidar_mapping::simulation
