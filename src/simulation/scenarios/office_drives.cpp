// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/units.hpp"

#include "motion/carrier_motion.hpp"
#include "scenarios/scenario.hpp"
#include "worlds/office.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kMesh = 0x600, kMotion };

using Points = std::vector<Eigen::Vector2d>;

/// Distance from the middle of a corridor to that of a room, m, by the dimensions of the building.
constexpr double kRoom = kOfficeCorridor + 0.5 * kOfficeRoomDepth;
constexpr double kL = kOfficeLength, kW = kOfficeWidth;

Scenario office_scenario(const DriveOptions& options, const Track& track, const Carrier& carrier) {
  const std::vector<Ground> floor(track.states().size());
  Scenario scenario =
      carrier_scenario(carried_trajectory(track, floor, carrier, Random(options.seed, kMotion)),
                       carrier.mounting, {{0.0, track.seconds()}});
  add_office(scenario.world.fixed, Random(options.seed, kMesh));
  return scenario;
}

/// A track round the floor and into three rooms, where `in_room` continues it.
template <typename InRoom>
Track track_through_rooms(const SpeedLimits& limits, const InRoom& in_room) {
  Track track({1.0, 0.0}, 0.0);
  track.stand(3.0);
  for (const Points& leg : {Points{{9.0, 0.0}, {9.0, -kRoom}},
                            Points{{9.0, 0.0}, {kL, 0.0}, {kL, 9.0}, {kL + kRoom, 9.0}},
                            Points{{kL, 9.0}, {kL, kW}, {21.0, kW}, {21.0, kW + kRoom}}}) {
    track.walk(leg, limits);
    in_room(track);
  }
  track.walk({{21.0, kW}, {0.0, kW}, {0.0, 0.0}, {3.0, 0.0}}, limits);
  track.stand(2.0);
  return track;
}

}  // namespace

Scenario make_handheld(const DriveOptions& options) {
  const auto look_around = [](Track& track) {
    track.stand(0.5);
    track.turn(2.0 * kPi, 2.5);
  };
  return office_scenario(options, track_through_rooms({1.4, 1.3, 1.2}, look_around),
                         hand_held_carrier());
}

Scenario make_spin(const DriveOptions& options) {
  const auto spin = [](Track& track) {
    for (const double angle : {2.0 * kPi, -2.0 * kPi, kPi, -kPi, kPi}) {
      track.turn(angle, 5.0);
      track.stand(0.3);
    }
  };
  return office_scenario(options, track_through_rooms({1.4, 1.3, 1.2}, spin), hand_held_carrier());
}

Scenario make_running(const DriveOptions& options) {
  Track track({1.0, 0.0}, 0.0);
  track.stand(3.0);
  const Points round = {{kL, 0.0}, {kL, kW}, {0.0, kW}, {0.0, 0.0}};
  for (int i = 0; i < 3; ++i) track.walk(round, {3.2, 3.0, 2.5}, {0.9, 0.3});
  track.walk({{3.0, 0.0}}, {1.5, 1.0, 1.0});
  track.stand(2.0);
  return office_scenario(options, track, running_carrier());
}

Scenario make_legged(const DriveOptions& options) {
  const auto turn_once = [](Track& track) { track.turn(2.0 * kPi, 1.5); };
  return office_scenario(options, track_through_rooms({1.0, 1.0, 0.8}, turn_once),
                         legged_carrier());
}

}  // namespace lidar_mapping::simulation
