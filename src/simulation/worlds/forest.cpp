// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/forest.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "worlds/ground.hpp"
#include "worlds/palette.hpp"
#include "worlds/street_furniture.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Width of the forest around the path, m; chosen: one sees no farther.
constexpr double kMargin = 35.0;
constexpr double kAreaPerTree = 22.0;  ///< m^2 per tree; chosen: 450 to a hectare, as usual.
constexpr double kCrownSpread = 0.9;   ///< Radius of a bush per metre of height, m; chosen.

struct Area {
  Eigen::Vector2d low, high;

  double size() const { return (high - low).prod(); }
  Eigen::Vector2d draw(Random& random) const {
    const double x = random.uniform(low.x(), high.x());
    return {x, random.uniform(low.y(), high.y())};
  }
};

Area around(const std::vector<Eigen::Vector2d>& path) {
  Area area{path.front(), path.front()};
  for (const Eigen::Vector2d& at : path) {
    area.low = area.low.cwiseMin(at);
    area.high = area.high.cwiseMax(at);
  }
  area.low.array() -= kMargin;
  area.high.array() += kMargin;
  return area;
}

double distance_to_path(const std::vector<Eigen::Vector2d>& path, const Eigen::Vector2d& at) {
  double nearest = 1e9;
  for (const Eigen::Vector2d& point : path) nearest = std::min(nearest, (point - at).squaredNorm());
  return std::sqrt(nearest);
}

/// A bare trunk with stumps of branches, and a crown above the path of a drone.
void add_conifer(TriangleMesh& mesh, const Eigen::Vector3d& foot, Random random) {
  const double height = random.uniform(9.0, 17.0), radius = random.uniform(0.08, 0.28);
  const double lean_y = random.uniform(-0.03, 0.03), lean_x = random.uniform(-0.03, 0.03);
  const Eigen::Vector3d lean(lean_x, lean_y, 1.0);
  add_tube(mesh, foot - Eigen::Vector3d(0.0, 0.0, 0.4), height * lean, radius, 0.3 * radius, 8,
           kBark);
  for (int i = random.integer(2, 7); i > 0; --i) {
    const double angle = random.uniform(0.0, 2.0 * kPi), length = random.uniform(0.2, 0.7);
    const double rise = random.uniform(-0.2, 0.4), up = random.uniform(1.5, 6.5);
    add_tube(mesh, foot + up * lean,
             length * Eigen::Vector3d(std::cos(angle), std::sin(angle), rise), 0.03, 0.01, 5,
             kBark);
  }
  const Random of_crown(random.bits());
  const double crown = random.uniform(2.0, 3.5);
  add_bush(mesh, foot + std::max(7.0, 0.6 * height) * lean, crown, of_crown);
}

void add_boulder(TriangleMesh& mesh, const Eigen::Vector3d& at, Random& random) {
  const double size_z = random.uniform(0.2, 0.8), size_y = random.uniform(0.3, 1.2);
  const double size_x = random.uniform(0.3, 1.2);
  const double about_z = random.uniform(-kPi, kPi), about_y = random.uniform(-0.4, 0.4);
  const double about_x = random.uniform(-0.4, 0.4);
  const Eigen::Vector3d size(size_x, size_y, size_z), rotation(about_x, about_y, about_z);
  add_box(mesh, {exp_so3(rotation), at}, size, kConcrete);
}

void add_log(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& at,
             Random& random) {
  const double angle = random.uniform(0.0, kPi), length = random.uniform(1.0, 3.0);
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  const Eigen::Vector3d from = terrain.on_ground(at - 0.5 * length * along, 0.1);
  const Eigen::Vector3d to = terrain.on_ground(at + 0.5 * length * along, 0.1);
  add_tube(mesh, from, to - from, random.uniform(0.1, 0.3), 0.1, 7, kBark);
}

}  // namespace

void add_forest(TriangleMesh& mesh, const Terrain& terrain,
                const std::vector<Eigen::Vector2d>& path, double clear, Random random) {
  const Area area = around(path);
  add_ground(mesh, terrain, area.low, area.high, 1.5, kSoil);
  for (int i = static_cast<int>(area.size() / kAreaPerTree); i > 0; --i) {
    const Eigen::Vector2d at = area.draw(random);
    const Random own(random.bits());
    if (distance_to_path(path, at) > clear + 0.7) add_conifer(mesh, terrain.on_ground(at), own);
  }
  for (int i = static_cast<int>(area.size() / (2.0 * kAreaPerTree)); i > 0; --i) {
    const Eigen::Vector2d at = area.draw(random);
    const double height = random.uniform(0.3, 1.6), kind = random.uniform();
    Random own(random.bits());
    const double distance = distance_to_path(path, at);
    if (kind < 0.6 && distance > clear + kCrownSpread * height + 0.2) {
      add_bush(mesh, terrain.on_ground(at), height, own);
    } else if (kind < 0.8 && distance > clear + 0.8) {
      add_boulder(mesh, terrain.on_ground(at), own);
    } else if (distance > clear + 1.8) {
      add_log(mesh, terrain, at, own);
    }
  }
}

}  // namespace lidar_mapping::simulation
