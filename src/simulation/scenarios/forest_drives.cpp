// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "motion/carrier_motion.hpp"
#include "motion/drone_motion.hpp"
#include "scenarios/scenario.hpp"
#include "sensors/mounting.hpp"
#include "worlds/forest.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kPath = 0x700, kTerrain, kMesh, kMotion };

using Points = std::vector<Eigen::Vector2d>;

constexpr double kClearOnFoot = 0.9;    ///< Free space beside the path on foot, m; chosen.
constexpr double kClearInFlight = 1.6;  ///< The same of a drone, m; chosen: rotors need more.

Terrain forest_floor(const DriveOptions& options) {
  return Terrain(Random(options.seed, kTerrain), 7, 16.0, 70.0, 0.14);
}

/// Corners of a round of about 150 m that ends at its beginning.
Points round_corners(const DriveOptions& options) {
  Random random(options.seed, kPath);
  Points corners = {{14.0, -3.0}, {32.0, 3.0}, {41.0, 16.0}, {36.0, 31.0},
                    {20.0, 36.0}, {7.0, 27.0}, {-6.0, 20.0}, {-8.0, 7.0}};
  for (Eigen::Vector2d& corner : corners) {
    const double dx = random.uniform(-2.5, 2.5);
    corner += Eigen::Vector2d(dx, random.uniform(-2.5, 2.5));
  }
  corners.emplace_back(0.0, 0.0);
  return corners;
}

/// Points on the track, a quarter of a second apart.
Points path_of(const Track& track) {
  Points path;
  for (std::size_t i = 0; i < track.states().size(); i += 50) {
    path.push_back(track.states()[i].position);
  }
  return path;
}

Scenario forest_scenario(const DriveOptions& options, const Track& track, double clear,
                         SmoothTrajectory trajectory, const SensorMounting& mounting) {
  Scenario scenario = carrier_scenario(std::move(trajectory), mounting, {});
  add_forest(scenario.world.fixed, forest_floor(options), path_of(track), clear,
             Random(options.seed, kMesh));
  return scenario;
}

std::vector<Ground> ground_under(const Track& track, const Terrain& terrain) {
  std::vector<Ground> ground;
  for (const TrackState& state : track.states()) {
    ground.push_back({terrain.height(state.position), terrain.gradient(state.position)});
  }
  return ground;
}

Scenario scenario_on_foot(const DriveOptions& options, const Track& track, const Carrier& carrier) {
  const std::vector<Ground> ground = ground_under(track, forest_floor(options));
  return forest_scenario(options, track, kClearOnFoot,
                         carried_trajectory(track, ground, carrier, Random(options.seed, kMotion)),
                         carrier.mounting);
}

/// A round and a little more.
Track round_track(const DriveOptions& options, const SpeedLimits& limits) {
  const Points corners = round_corners(options);
  Track track({0.0, 0.0}, 0.0);
  track.stand(3.0);
  track.walk(Points(corners.begin(), corners.begin() + 4), limits, {3.0, 0.5});
  track.turn(2.0 * kPi, 2.0);
  track.walk(Points(corners.begin() + 4, corners.end()), limits, {3.0, 0.5});
  track.walk({0.5 * corners.front()}, limits, {3.0, 0.5});
  track.stand(2.0);
  return track;
}

}  // namespace

Scenario make_handheld_forest(const DriveOptions& options) {
  return scenario_on_foot(options, round_track(options, {1.4, 1.3, 1.2}), hand_held_carrier());
}

Scenario make_running_forest(const DriveOptions& options) {
  return scenario_on_foot(options, round_track(options, {3.5, 4.0, 2.5}), running_carrier());
}

Scenario make_legged_forest(const DriveOptions& options) {
  return scenario_on_foot(options, round_track(options, {1.0, 1.0, 0.8}), legged_carrier());
}

Scenario make_drone(const DriveOptions& options) {
  const Points corners = round_corners(options);
  Track track({0.0, 0.0}, 0.0);
  track.stand(7.0);
  for (int i = 0; i < 2; ++i) track.walk(corners, {7.5, 8.0, 6.0}, {7.0, 1.0});
  track.stand(6.0);
  SmoothTrajectory flight = flown_trajectory(track, ground_under(track, forest_floor(options)),
                                             Random(options.seed, kMotion));
  return forest_scenario(options, track, kClearInFlight, std::move(flight), drone_mounting());
}

}  // namespace lidar_mapping::simulation
