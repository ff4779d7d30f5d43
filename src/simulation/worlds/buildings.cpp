// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/buildings.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Properties that all facades of a house share.
struct Style {
  double floor_height;
  double bay;  ///< Distance between windows, m.
  double window_width;
  double window_height;
  double sill;              ///< Height of the sill above the floor, m.
  double recess;            ///< Depth of the windows behind the wall, m.
  double ledge;             ///< Depth of the ledges, m; 0: none.
  double plinth;            ///< Depth of the plinth, m.
  double blind_fraction;    ///< Fraction of bays without a window.
  double balcony_fraction;  ///< Fraction of bays above the ground floor with a balcony.
  bool gabled;
  bool shop;
  Reflectivity wall;
};

Style draw_style(Random& random) {
  Style style{};
  style.floor_height = random.uniform(2.8, 3.5);
  style.bay = random.uniform(2.2, 4.2);
  style.window_width = random.uniform(0.9, std::min(2.4, style.bay - 0.7));
  style.window_height = random.uniform(1.2, 1.9);
  style.sill = random.uniform(0.6, 0.9);
  style.recess = random.uniform(0.1, 0.35);
  style.ledge = random.chance(0.6) ? random.uniform(0.06, 0.25) : 0.0;
  style.plinth = random.uniform(0.0, 0.1);
  style.blind_fraction = random.uniform(0.05, 0.3);
  style.balcony_fraction = random.chance(0.4) ? random.uniform(0.2, 0.6) : 0.0;
  style.gabled = random.chance(0.6);
  style.shop = random.chance(0.25);
  style.wall = static_cast<Reflectivity>(random.integer(70, 200));
  return style;
}

/// A wall in its own axes: `along` the wall, `up`, and `out` of it.
class Facade {
 public:
  /// T_mesh_wall: x along the wall, z up; the outside is towards -y.
  Facade(TriangleMesh& mesh, const Pose& T_mesh_wall) : mesh_(mesh), T_mesh_wall_(T_mesh_wall) {}

  Eigen::Vector3d at(double along, double up, double out) const {
    return T_mesh_wall_ * Eigen::Vector3d(along, -out, up);
  }
  void panel(double a0, double a1, double u0, double u1, double out, Reflectivity r) {
    if (a1 <= a0 || u1 <= u0) return;
    add_quad(mesh_, at(a0, u0, out), at(a1, u0, out), at(a1, u1, out), at(a0, u1, out), r);
  }
  /// A block from the wall to `out` metres before it.
  void block(double a0, double a1, double u0, double u1, double out, Reflectivity r) {
    const Pose T_mesh_block =
        T_mesh_wall_ * Pose{Eigen::Quaterniond::Identity(),
                            Eigen::Vector3d(0.5 * (a0 + a1), -0.5 * out, 0.5 * (u0 + u1))};
    add_box(mesh_, T_mesh_block, {a1 - a0, out, u1 - u0}, r);
  }
  /// A part of the wall from (a0, u0) to (a1, u1) with an opening `depth` deep.
  void opening(double a0, double a1, double u0, double u1, double w0, double w1, double v0,
               double v1, double depth, Reflectivity wall, Reflectivity pane) {
    panel(a0, a1, u0, v0, 0.0, wall);
    panel(a0, a1, v1, u1, 0.0, wall);
    panel(a0, w0, v0, v1, 0.0, wall);
    panel(w1, a1, v0, v1, 0.0, wall);
    panel(w0, w1, v0, v1, -depth, pane);
    add_quad(mesh_, at(w0, v0, 0), at(w1, v0, 0), at(w1, v0, -depth), at(w0, v0, -depth), wall);
    add_quad(mesh_, at(w0, v1, 0), at(w1, v1, 0), at(w1, v1, -depth), at(w0, v1, -depth), wall);
    add_quad(mesh_, at(w0, v0, 0), at(w0, v1, 0), at(w0, v1, -depth), at(w0, v0, -depth), wall);
    add_quad(mesh_, at(w1, v0, 0), at(w1, v1, 0), at(w1, v1, -depth), at(w1, v0, -depth), wall);
  }

 private:
  TriangleMesh& mesh_;
  Pose T_mesh_wall_;
};

Reflectivity pane_reflectivity(Random& random) {
  return random.chance(0.5) ? kGlass : static_cast<Reflectivity>(random.integer(60, 180));
}

/// One bay of one floor: a window, a door, a shop window or blank wall.
void add_bay(Facade& facade, const Style& style, double a0, double a1, double u0, bool ground,
             Random& random) {
  const double u1 = u0 + style.floor_height, middle = 0.5 * (a0 + a1);
  double half = 0.5 * std::min(style.window_width, a1 - a0 - 0.4);
  double v0 = u0 + style.sill, v1 = std::min(v0 + style.window_height, u1 - 0.2);
  double depth = style.recess;
  if (random.chance(style.blind_fraction) || half < 0.2) {
    facade.panel(a0, a1, u0, u1, 0.0, style.wall);
    return;
  }
  if (ground && style.shop) {
    half = 0.5 * (a1 - a0) - 0.25;
    v0 = u0 + 0.4;
    v1 = u1 - 0.5;
  } else if (ground && random.chance(0.2)) {
    half = 0.55;
    v0 = u0 + 0.02;
    v1 = u0 + 2.2;
    depth = style.recess + 0.3;
  }
  const double shift = random.uniform(-0.1, 0.1);
  facade.opening(a0, a1, u0, u1, middle + shift - half, middle + shift + half, v0, v1, depth,
                 style.wall, pane_reflectivity(random));
  if (!ground && random.chance(style.balcony_fraction)) {
    facade.block(a0 + 0.15, a1 - 0.15, u0 - 0.1, u0 + 1.0, random.uniform(0.9, 1.4), kConcrete);
  }
}

void add_facade(TriangleMesh& mesh, const Pose& T_mesh_wall, double width, const HousePlan& plan,
                const Style& style, Random& random) {
  Facade facade(mesh, T_mesh_wall);
  const int bays = std::max(1, static_cast<int>(std::lround(width / style.bay)));
  const double bay = width / bays, height = plan.floors * style.floor_height;
  facade.panel(0.0, width, -plan.cellar, 0.0, 0.0, kConcrete);
  if (style.plinth > 0.02) facade.block(0.0, width, -plan.cellar, 0.35, style.plinth, kConcrete);
  for (int floor = 0; floor < plan.floors; ++floor) {
    const double up = floor * style.floor_height;
    for (int b = 0; b < bays; ++b) {
      add_bay(facade, style, b * bay, (b + 1) * bay, up, floor == 0, random);
    }
    if (floor > 0 && style.ledge > 0.0) {
      facade.block(0.0, width, up - 0.1, up + 0.12, style.ledge, style.wall);
    }
  }
  facade.block(0.0, width, height - 0.15, height, 0.3, kConcrete);
  if (random.chance(0.7)) {
    const double pipe = random.chance(0.5) ? 0.25 : width - 0.25;
    add_tube(mesh, facade.at(pipe, -plan.cellar, 0.12), {0.0, 0.0, height + plan.cellar}, 0.06,
             0.06, 6, kSteel);
  }
}

void add_roof(TriangleMesh& mesh, const Pose& T_mesh_house, const HousePlan& plan,
              const Style& style, Random& random) {
  const double height = plan.floors * style.floor_height;
  const double x = 0.5 * plan.width + 0.3, y0 = -0.4, y1 = plan.depth + 0.4;
  const auto at = [&](double px, double py, double pz) -> Eigen::Vector3d {
    return T_mesh_house * Eigen::Vector3d(px, py, pz);
  };
  const double rise = style.gabled ? random.uniform(0.35, 0.8) * 0.5 * plan.depth : 0.0;
  const double ridge = 0.5 * (y0 + y1);
  add_quad(mesh, at(-x, y0, height), at(x, y0, height), at(x, ridge, height + rise),
           at(-x, ridge, height + rise), kRoofTile);
  add_quad(mesh, at(-x, y1, height), at(x, y1, height), at(x, ridge, height + rise),
           at(-x, ridge, height + rise), kRoofTile);
  for (const double side : {-0.5 * plan.width, 0.5 * plan.width}) {
    add_triangle(mesh, at(side, 0.0, height), at(side, plan.depth, height),
                 at(side, ridge, height + rise), style.wall);
  }
  for (int i = random.integer(0, 2); i > 0; --i) {
    const double deep = random.uniform(0.2, 0.8) * plan.depth;
    const double along = random.uniform(-0.4, 0.4) * plan.width;
    const Eigen::Vector3d foot(along, deep, height + 0.8 * rise);
    add_box(mesh, T_mesh_house * Pose{Eigen::Quaterniond::Identity(), foot},
            {random.uniform(0.5, 1.0), random.uniform(0.5, 0.9), 2.0}, style.wall);
  }
}

}  // namespace

void add_house(TriangleMesh& mesh, const Pose& T_mesh_house, const HousePlan& plan, Random random) {
  const Style style = draw_style(random);
  const double half = 0.5 * plan.width;
  const auto wall = [&](double x, double y, double yaw, double width) {
    const Pose T_house_wall{rotation_about_z(yaw), {x, y, 0.0}};
    add_facade(mesh, T_mesh_house * T_house_wall, width, plan, style, random);
  };
  wall(-half, 0.0, 0.0, plan.width);
  wall(half, 0.0, 0.5 * kPi, plan.depth);
  wall(half, plan.depth, kPi, plan.width);
  wall(-half, plan.depth, -0.5 * kPi, plan.depth);
  add_roof(mesh, T_mesh_house, plan, style, random);
}

}  // namespace lidar_mapping::simulation
