// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"

#include "scenarios/road_drive.hpp"
#include "worlds/buildings.hpp"
#include "worlds/palette.hpp"
#include "worlds/road_strip.hpp"
#include "worlds/street_furniture.hpp"
#include "worlds/traffic.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kMesh = 0x300, kTraffic, kMotion };

/// From the path to the middle of the road, m; chosen, as a lane of 3.5 m.
constexpr double kLane = 1.75;
constexpr double kRoadHalfWidth = 4.4;  ///< m; chosen: two lanes and margins
constexpr double kTubeHalfWidth = 5.2;  ///< m; chosen: the road and a walkway on each side
constexpr double kWallHeight = 1.8;     ///< Height at which the arch begins, m; chosen.
constexpr double kPortalIn = 160.0;     ///< Station of a portal, m; chosen: in the open first.
constexpr double kPortalOut = 460.0;    ///< 300 m of tube; chosen, so that no portal is near

/// Outline of the tube across the road: walls and an arch over them.
std::vector<Eigen::Vector2d> tube_outline() {
  constexpr int kArchFaces = 28;  // chosen: edges stay 1 cm off the circle
  std::vector<Eigen::Vector2d> outline = {{-kTubeHalfWidth, -0.3}};
  for (int i = 0; i <= kArchFaces; ++i) {
    const double angle = kPi * (1.0 - static_cast<double>(i) / kArchFaces);
    outline.emplace_back(kTubeHalfWidth * std::cos(angle),
                         kWallHeight + kTubeHalfWidth * std::sin(angle));
  }
  outline.emplace_back(kTubeHalfWidth, -0.3);
  return outline;
}

Eigen::Vector3d across_road(const Path& path, double s, double across, double up) {
  const Eigen::Vector2d at = beside(path, s, kLane - across);
  return {at.x(), at.y(), up};
}

void add_tube_walls(TriangleMesh& mesh, const Path& path) {
  const std::vector<Eigen::Vector2d> outline = tube_outline();
  constexpr double kStep = 1.0;  // m; chosen, the path is nearly straight there
  for (double s = kPortalIn; s < kPortalOut; s += kStep) {
    for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
      const Eigen::Vector2d &a = outline[i], &b = outline[i + 1];
      add_quad(mesh, across_road(path, s, a.x(), a.y()), across_road(path, s, b.x(), b.y()),
               across_road(path, s + kStep, b.x(), b.y()),
               across_road(path, s + kStep, a.x(), a.y()), kConcrete);
    }
  }
}

/// A wall around the mouth of the tube with wings on both sides.
void add_portal(TriangleMesh& mesh, const Path& path, double s) {
  constexpr double kTop = 10.0, kWing = 24.0;  // m, height and half width of the portal; chosen
  const std::vector<Eigen::Vector2d> outline = tube_outline();
  const auto at = [&](double across, double up) { return across_road(path, s, across, up); };
  for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[i + 1];
    if (a.x() == b.x()) continue;
    add_quad(mesh, at(a.x(), a.y()), at(b.x(), b.y()), at(b.x(), kTop), at(a.x(), kTop), kConcrete);
  }
  for (const double side : {-1.0, 1.0}) {
    add_quad(mesh, at(side * kTubeHalfWidth, -0.5), at(side * kTubeHalfWidth, kTop),
             at(side * kWing, 2.0), at(side * kWing, -0.5), kConcrete);
  }
}

/// Adds trees, lamps and signs along the road outside of the tube.
void add_roadside(TriangleMesh& mesh, const Terrain& ground, const Path& path, Random& random) {
  for (double s = 2.0; s < path.length(); s += random.uniform(6.0, 14.0)) {
    const bool outside = s < kPortalIn - 8.0 || s > kPortalOut + 8.0;
    const double side = random.chance(0.5) ? 1.0 : -1.0;
    const double off = kRoadHalfWidth + random.uniform(2.0, 14.0);
    const double pick = random.uniform();
    const Random own(random.bits());
    if (!outside) continue;
    const Eigen::Vector2d at = beside(path, s, kLane + side * off);
    const Eigen::Vector3d foot = ground.on_ground(at);
    if (pick < 0.45) {
      add_tree(mesh, foot, 5.0 + 6.0 * pick, own);
    } else if (pick < 0.7) {
      add_bush(mesh, foot, 1.5, own);
    } else if (pick < 0.85) {
      add_lamp(mesh, foot, path.heading(s) - side * 0.5 * kPi, own);
    } else {
      add_sign(mesh, foot, path.heading(s) + kPi, own);
    }
  }
}

void add_houses(TriangleMesh& mesh, const Path& path, Random& random) {
  for (double s = 15.0; s < path.length() - 10.0; s += random.uniform(22.0, 45.0)) {
    const double side = random.chance(0.5) ? 1.0 : -1.0;
    HousePlan plan{random.uniform(9.0, 16.0), random.uniform(8.0, 11.0), random.integer(1, 3), 0.6};
    const double off = random.uniform(19.0, 26.0), turn = random.uniform(-0.2, 0.2);
    const Random own(random.bits());
    if (s > kPortalIn - 25.0 && s < kPortalOut + 25.0) continue;
    const Eigen::Vector2d at = beside(path, s, kLane + side * off);
    // The front faces the road.
    const double yaw = path.heading(s) + (side > 0.0 ? 0.0 : kPi) + turn;
    add_house(mesh, {rotation_about_z(yaw), {at.x(), at.y(), 0.1}}, plan, own);
  }
}

}  // namespace

Scenario make_tunnel(const DriveOptions& options) {
  const Terrain ground;
  const Path path = Path::rounded({{0.0, 0.0}, {250.0, 0.0}, {480.0, 70.0}, {630.0, 70.0}}, 320.0);
  const std::vector<double> stations = stations_along(path, 8.0, 8.0, false, {14.0, 2.4, 1.8});
  Scenario scenario =
      car_scenario(path, stations, ground_along(path, ground), Random(options.seed, kMotion),
                   {{time_at(stations, kPortalIn), time_at(stations, kPortalOut)}});
  Random random(options.seed, kMesh);
  TriangleMesh& mesh = scenario.world.fixed;
  add_meadow(mesh, ground, {-120.0, -130.0}, {760.0, 200.0}, Random(random.bits()));
  add_road_strip(mesh, ground, path, kLane, kTubeHalfWidth);
  add_tube_walls(mesh, path);
  add_portal(mesh, path, kPortalIn);
  add_portal(mesh, path, kPortalOut);
  add_roadside(mesh, ground, path, random);
  add_houses(mesh, path, random);
  if (options.movers) {
    const TrafficLane oncoming{reversed(path, 2.0 * kLane), 10.0, 16.0};
    add_traffic(scenario.world, {oncoming}, ground, scenario.trajectory, 6,
                Random(options.seed, kTraffic));
  }
  return scenario;
}

}  // namespace lidar_mapping::simulation
