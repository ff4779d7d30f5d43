// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/town_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"

#include "worlds/buildings.hpp"
#include "worlds/ground.hpp"
#include "worlds/palette.hpp"
#include "worlds/parked_cars.hpp"
#include "worlds/street_furniture.hpp"
#include "worlds/vehicles.hpp"

namespace lidar_mapping::simulation {

namespace {

/// One side of a block: a kerb from `begin` in direction `along`, with gardens and houses in
/// direction `inwards`.
struct Frontage {
  Eigen::Vector2d begin;
  Eigen::Vector2d along;
  Eigen::Vector2d inwards;
  double length;
  double yaw;  ///< Direction of `along`, rad.

  Eigen::Vector2d at(double s, double in) const { return begin + s * along + in * inwards; }
};

Frontage frontage(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = (b - a).normalized();
  return {a, along, {-along.y(), along.x()}, (b - a).norm(), std::atan2(along.y(), along.x())};
}

constexpr double kPavementWidth = 2.6;  ///< m; chosen, as in usual streets

class BlockBuilder {
 public:
  BlockBuilder(TriangleMesh& mesh, const Terrain& terrain, Random random, std::uint64_t parking_day)
      : mesh_(mesh), terrain_(terrain), random_(random), parking_day_(parking_day) {}

  void build(const std::array<Eigen::Vector2d, 4>& corners) {
    add_pavement(mesh_, terrain_, corners, kKerbHeight);
    for (int i = 0; i < 4; ++i) {
      const Frontage side = frontage(corners[i], corners[(i + 1) % 4]);
      add_houses(side);
      add_furniture(side);
      add_parked_cars(mesh_, random_, parking_day_,
                      [&](TriangleMesh& to, Random& own) { park_cars(to, side, own); });
    }
    for (int i = random_.integer(1, 5); i > 0; --i) add_back_yard_tree(corners);
  }

 private:
  Random split() { return Random(random_.bits()); }
  Eigen::Vector3d on_pavement(const Eigen::Vector2d& at) const {
    return terrain_.on_ground(at, kKerbHeight);
  }

  /// Adds lots of different widths, most of them with a house. The first metres belong to the
  /// previous side.
  void add_houses(const Frontage& side) {
    const double end = side.length - kPavementWidth - 2.0;
    double s = 17.0;
    while (end - s > 7.0) {
      double width = random_.uniform(8.0, 19.0);
      if (end - s - width < 7.0) width = end - s;
      if (random_.chance(0.82)) {
        add_lot(side, s, std::min(width, 22.0));
      } else {
        add_open_lot(side, s, width);
      }
      s += width + (random_.chance(0.45) ? random_.uniform(1.5, 4.5) : 0.0);
    }
    if (end > 17.0 && random_.chance(0.7)) add_open_lot(side, kPavementWidth + 1.0, 12.0);
  }

  void add_lot(const Frontage& side, double s, double width) {
    const double garden = random_.chance(0.45) ? random_.uniform(1.5, 4.0) : 0.0;
    const double in = kPavementWidth + garden + random_.uniform(0.0, 0.5);
    HousePlan plan;
    plan.width = width;
    plan.depth = random_.uniform(8.0, 11.5);
    plan.floors = random_.integer(1, 4);
    const Eigen::Vector2d front = side.at(s + 0.5 * width, in);
    const Eigen::Vector3d foot = on_pavement(front);
    const Pose T_mesh_house{rotation_about_z(side.yaw),
                            foot + Eigen::Vector3d(0.0, 0.0, random_.uniform(0.05, 0.5))};
    plan.cellar = 2.5;
    add_house(mesh_, T_mesh_house, plan, split());
    if (garden > 0.0) add_garden(side, s, width, garden);
  }

  void add_garden(const Frontage& side, double s, double width, double garden) {
    const double line = kPavementWidth + 0.1;
    const double gate = random_.uniform(0.2, 0.7) * width;
    add_fence(mesh_, on_pavement(side.at(s + 0.2, line)), on_pavement(side.at(s + gate, line)),
              split());
    if (width - gate > 3.0) {
      add_fence(mesh_, on_pavement(side.at(s + gate + 1.4, line)),
                on_pavement(side.at(s + width - 0.2, line)), split());
    }
    if (garden > 2.2 && random_.chance(0.6)) {
      const Random own = split();
      const double height = random_.uniform(0.7, 1.7);
      const double along = s + random_.uniform(0.2, 0.8) * width;
      add_bush(mesh_, on_pavement(side.at(along, line + 1.2)), height, own);
    }
  }

  void add_open_lot(const Frontage& side, double s, double width) {
    const double line = kPavementWidth + 0.3;
    if (random_.chance(0.7)) {
      add_fence(mesh_, on_pavement(side.at(s, line)), on_pavement(side.at(s + width, line)),
                split());
    }
    for (int i = random_.integer(0, 3); i > 0; --i) {
      const double in = line + random_.uniform(1.5, 7.0);
      const Eigen::Vector2d at = side.at(s + random_.uniform(0.15, 0.85) * width, in);
      const bool is_tree = random_.chance(0.6);
      const Random own = split();
      if (is_tree) {
        add_tree(mesh_, on_pavement(at), random_.uniform(5.0, 12.0), own);
      } else {
        add_bush(mesh_, on_pavement(at), random_.uniform(0.8, 2.2), own);
      }
    }
  }

  void add_back_yard_tree(const std::array<Eigen::Vector2d, 4>& corners) {
    const double u = random_.uniform(0.35, 0.65), v = random_.uniform(0.35, 0.65);
    const Eigen::Vector2d at = (1.0 - v) * ((1.0 - u) * corners[0] + u * corners[1]) +
                               v * ((1.0 - u) * corners[3] + u * corners[2]);
    const Random own = split();
    add_tree(mesh_, on_pavement(at), random_.uniform(6.0, 13.0), own);
  }

  /// Adds trees, lamps, signs and boxes along the kerb.
  void add_furniture(const Frontage& side) {
    const bool avenue = random_.chance(0.4);
    for (double s = random_.uniform(3.0, 9.0); s < side.length - 3.0;
         s += random_.uniform(5.0, 13.0)) {
      const Eigen::Vector3d foot = on_pavement(side.at(s, random_.uniform(0.4, 0.7)));
      const double pick = random_.uniform();
      if (avenue && pick < 0.6) {
        const Random own = split();
        add_tree(mesh_, foot, random_.uniform(4.5, 9.0), own);
      } else if (pick < 0.75) {
        add_lamp(mesh_, foot, side.yaw - 0.5 * kPi, split());
      } else if (pick < 0.9) {
        const Random own = split();
        add_sign(mesh_, foot, side.yaw + (random_.chance(0.5) ? kPi : 0.0), own);
      } else {
        add_street_box(mesh_, on_pavement(side.at(s, 1.9)), side.yaw, split());
      }
    }
  }

  void park_cars(TriangleMesh& mesh, const Frontage& side, Random& random) const {
    const double density = random.uniform(0.2, 0.8);
    for (double s = 9.0; s < side.length - 9.0; s += random.uniform(5.6, 7.4)) {
      if (!random.chance(density)) continue;
      const Eigen::Vector2d at = side.at(s, -1.1 + random.uniform(-0.1, 0.15));
      const double yaw = side.yaw + random.uniform(-0.03, 0.03);
      const bool is_van = random.chance(0.15);
      const Random own(random.bits());
      append(mesh, is_van ? make_van(own) : make_car(own), on_slope(terrain_, at, yaw));
    }
  }

  TriangleMesh& mesh_;
  const Terrain& terrain_;
  Random random_;
  std::uint64_t parking_day_;
};

}  // namespace

TriangleMesh make_town_mesh(const TownLayout& layout, const Terrain& terrain, Random random,
                            std::uint64_t parking_day) {
  TriangleMesh mesh;
  const std::uint64_t seed = random.bits();
  const Eigen::Vector2d margin(25.0, 25.0);
  add_ground(mesh, terrain, layout.crossing({0, 0}) - margin,
             layout.crossing({layout.columns() - 1, layout.rows() - 1}) + margin, 2.5, kAsphalt);
  for (int row = 0; row + 1 < layout.rows(); ++row) {
    for (int column = 0; column + 1 < layout.columns(); ++column) {
      const int block = layout.rows_alike() ? column : row * layout.columns() + column;
      BlockBuilder(mesh, terrain, Random(seed, static_cast<std::uint64_t>(block)), parking_day)
          .build(layout.block({column, row}));
    }
  }
  return mesh;
}

}  // namespace lidar_mapping::simulation
