// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/units.hpp"

#include "scenarios/road_drive.hpp"
#include "worlds/palette.hpp"
#include "worlds/road_strip.hpp"
#include "worlds/street_furniture.hpp"
#include "worlds/traffic.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kPath = 0x200, kTerrain, kMesh, kTraffic, kMotion };

constexpr double kRoadHalfWidth = 3.2;  ///< m; chosen, as of a usual country road
/// From the path to the middle of the road, m: half of kRoadHalfWidth.
constexpr double kLane = 1.6;

/// Corners of a round of about 900 m through the fields and a little more.
std::vector<Eigen::Vector2d> corners(Random random) {
  const std::vector<Eigen::Vector2d> round = {{0.0, 0.0},     {180.0, -30.0}, {300.0, 60.0},
                                              {240.0, 190.0}, {90.0, 150.0},  {-60.0, 210.0},
                                              {-110.0, 70.0}};
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector2d& corner : round) {
    const double dx = random.uniform(-12.0, 12.0), dy = random.uniform(-12.0, 12.0);
    corners.push_back(corner + Eigen::Vector2d(dx, dy));
  }
  const Eigen::Vector2d middle_of_first = 0.5 * (corners[0] + corners[1]);
  corners.push_back(corners[0]);
  corners.push_back(corners[1]);
  corners[0] = middle_of_first - 0.15 * (corners[1] - corners[0]);
  return corners;
}

/// Adds trees and bushes beside the road.
void add_plants(TriangleMesh& mesh, const Terrain& terrain, const Path& path, Random& random) {
  for (int i = 0; i < 260; ++i) {
    const double y = random.uniform(-150.0, 330.0), x = random.uniform(-230.0, 420.0);
    const Eigen::Vector2d at(x, y);
    const double size = random.uniform();
    const Random own(random.bits());
    if (distance_to(path, at) < 8.0) continue;
    if (size < 0.5) {
      add_tree(mesh, terrain.on_ground(at), 5.0 + 14.0 * size, own);
    } else {
      add_bush(mesh, terrain.on_ground(at), 0.5 + 2.0 * (size - 0.5), own);
    }
  }
}

/// Adds marker posts at irregular distances and a few signs.
void add_posts(TriangleMesh& mesh, const Terrain& terrain, const Path& path, Random& random) {
  for (double s = 10.0; s < path.length(); s += random.uniform(25.0, 70.0)) {
    const double side = random.chance(0.5) ? kRoadHalfWidth + 1.0 : -kRoadHalfWidth - 1.0;
    const Eigen::Vector3d foot = terrain.on_ground(beside(path, s, side + kLane));
    if (random.chance(0.25)) {
      add_sign(mesh, foot, path.heading(s) + kPi, Random(random.bits()));
    } else {
      add_tube(mesh, foot, {0.0, 0.0, 1.0}, 0.06, 0.05, 6, kSign);
    }
  }
}

}  // namespace

Scenario make_open_road(const DriveOptions& options) {
  const Terrain terrain(Random(options.seed, kTerrain), 6, 110.0, 300.0, 0.05);
  const Path forward = Path::rounded(corners(Random(options.seed, kPath)), 45.0).weaving(0.15, 1.0);
  const Path backward = reversed(forward, 2.0 * kLane);
  const Path& path = options.reverse ? backward : forward;
  const std::vector<double> stations =
      stations_along(path, 2.0, 15.0, options.reverse, {17.0, 2.4, 1.8});
  Scenario scenario =
      car_scenario(path, stations, ground_along(path, terrain), Random(options.seed, kMotion));
  Random random(options.seed, kMesh);
  TriangleMesh& mesh = scenario.world.fixed;
  add_meadow(mesh, terrain, {-250.0, -170.0}, {440.0, 350.0}, Random(random.bits()));
  add_road_strip(mesh, terrain, forward, kLane, kRoadHalfWidth);
  add_plants(mesh, terrain, forward, random);
  add_posts(mesh, terrain, forward, random);
  if (options.movers) {
    const TrafficLane oncoming{options.reverse ? forward : backward, 12.0, 18.0};
    add_traffic(scenario.world, {oncoming}, terrain, scenario.trajectory, 5,
                Random(options.seed, kTraffic));
  }
  return scenario;
}

}  // namespace lidar_mapping::simulation
