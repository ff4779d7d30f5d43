// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "motion/carrier_motion.hpp"
#include "motion/smoothing.hpp"
#include "scenarios/scenario.hpp"
#include "worlds/stair_building.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kMesh = 0x800, kMotion };

using Points = std::vector<Eigen::Vector2d>;
constexpr double kStep = Track::kStep;  ///< s

constexpr SpeedLimits kWalking{1.1, 1.0, 1.0};

constexpr double kLiftSpeed = 1.6;    ///< m/s; chosen as of usual lifts
constexpr double kDoorSeconds = 2.0;  ///< s, of opening and of closing; chosen
constexpr double kMoverStep = 0.05;   ///< s between poses; chosen: half a scan
constexpr double kCarDoor = -1.06;    ///< y of the door of the car, relative to the car, m; chosen.
/// Doors of the storeys: their y, m, by kHalfWidth of the corridor and half of its wall.
constexpr double kStoreyDoor = 1.42;

Scenario building_scenario(const DriveOptions& options, const Track& track,
                           const std::vector<Ground>& floor, const Carrier& carrier) {
  Scenario scenario =
      carrier_scenario(carried_trajectory(track, floor, carrier, Random(options.seed, kMotion)),
                       carrier.mounting, {{0.0, track.seconds()}});
  add_stair_building(scenario.world.fixed, Random(options.seed, kMesh));
  return scenario;
}

/// Appends the stairs between two neighbouring storeys, up or down, from and to their main landing.
void add_storey(Points& points, bool up) {
  const double first = up ? kStairLane : -kStairLane;
  points.insert(points.end(), {{kMainLanding, first},
                               {kHalfLanding, first},
                               {kHalfLanding, -first},
                               {kMainLanding, -first}});
}

/// Motion of the lift over the states of a track.
struct Ride {
  std::vector<double> floor;   ///< Height of the floor of the car, m.
  std::vector<double> closed;  ///< State of the door: 0 open, 1 closed.
};

/// Walks into the car and turns round.
void enter(Track& track) {
  track.walk({{kLiftX, 0.0}}, kWalking);
  track.walk({{kLiftX, kLiftY + 0.15}}, kWalking, {0.3, 0.1});
  track.turn(kPi, 2.0);
  track.stand(0.5);
}

/// Stands in the car while its door closes, the car moves to a height and its door opens.
void ride_to(Track& track, Ride& ride, double height) {
  const double from = ride.floor.empty() ? 0.0 : ride.floor.back();
  ride.floor.resize(track.states().size(), from);
  ride.closed.resize(track.states().size(), 0.0);
  const double travel = std::abs(height - from) / kLiftSpeed;
  const double seconds = 2.0 * kDoorSeconds + travel + 6.0;
  for (double t = 0.0; t < seconds; t += kStep) {
    const double u = std::clamp((t - kDoorSeconds - 3.0) / travel, 0.0, 1.0);
    ride.floor.push_back(from + u * (height - from));
    ride.closed.push_back(
        std::clamp(std::min(t / kDoorSeconds, (seconds - t) / kDoorSeconds), 0.0, 1.0));
  }
  track.stand(static_cast<double>(ride.floor.size() - track.states().size()) * kStep);
}

/// Smooths the motion of the car: it accelerates and brakes within two seconds, without a jerk.
void smooth_ride(const Track& track, Ride& ride) {
  ride.floor.resize(track.states().size(), ride.floor.back());
  ride.closed.resize(track.states().size(), 0.0);
  ride.floor = smoothed(std::move(ride.floor), static_cast<int>(std::lround(0.9 / kStep)), 1);
  ride.floor = smoothed(std::move(ride.floor), static_cast<int>(std::lround(0.25 / kStep)), 3);
}

/// Adds a shape whose position at each state is given by `pose`.
template <typename PoseOf>
void add_mover(World& world, TriangleMesh shape, std::size_t states, const PoseOf& pose) {
  // By geometry, a spline of degree 5 (smooth_trajectory.cpp) follows its control points with a
  // delay of two steps.
  constexpr std::size_t kSplineDelay = 2;
  Mover mover;
  mover.step_s = kMoverStep;
  const auto every = static_cast<std::size_t>(std::lround(kMoverStep / kStep));
  for (std::size_t i = kSplineDelay; i < states; i += every) {
    mover.T_map_shape.push_back({Eigen::Quaterniond::Identity(), pose(i)});
  }
  world.add(std::move(shape), std::move(mover));
}

void add_lift(World& world, const Ride& ride) {
  const std::size_t states = ride.floor.size();
  const auto opened = [&](std::size_t i) { return 1.0 - ride.closed[i]; };
  add_mover(world, make_lift_car(), states,
            [&](std::size_t i) { return Eigen::Vector3d(kLiftX, kLiftY, ride.floor[i]); });
  add_mover(world, make_lift_door(), states, [&](std::size_t i) {
    return Eigen::Vector3d(kLiftX + opened(i), kLiftY + kCarDoor, ride.floor[i]);
  });
  for (int storey = 0; storey < kStairStoreys; ++storey) {
    const double z = storey * kStairStorey;
    add_mover(world, make_lift_door(), states, [&](std::size_t i) {
      const bool is_here = std::abs(ride.floor[i] - z) < 0.01;
      return Eigen::Vector3d(kLiftX + (is_here ? opened(i) : 0.0), kStoreyDoor, z);
    });
  }
}

}  // namespace

Scenario make_stairs(const DriveOptions& options) {
  Track track({-11.0, 0.0}, 0.0);
  track.stand(3.0);
  Points up = {{-2.4, 0.3}};
  for (int i = 1; i < kStairStoreys; ++i) add_storey(up, true);
  up.insert(up.end(), {{-2.4, -0.3}, {-11.0, -0.1}});
  track.walk(up, kWalking, {0.5, 0.15});
  Points down = {{-2.4, -0.3}};
  for (int i = 1; i < kStairStoreys; ++i) add_storey(down, false);
  down.insert(down.end(), {{-2.4, 0.3}, {-11.0, 0.1}});
  track.walk(down, kWalking, {0.5, 0.15});
  track.stand(2.0);
  Carrier carrier = hand_held_carrier();
  carrier.step_length = 0.45;
  carrier.push = 5.5;
  return building_scenario(options, track, floor_in_stair_building(track), carrier);
}

Scenario make_elevator(const DriveOptions& options) {
  Track track({-3.0, 0.0}, kPi);
  Ride ride;
  track.stand(3.0);
  for (const int storey : {3, 1}) {
    enter(track);
    ride_to(track, ride, storey * kStairStorey);
    track.walk({{kLiftX, 0.0}}, kWalking);
    track.walk({{-12.0, 0.0}}, kWalking);
    track.walk({{-3.0, 0.0}}, kWalking);
  }
  track.stand(2.0);
  smooth_ride(track, ride);
  std::vector<Ground> floor;
  for (const double height : ride.floor) floor.push_back({height, Eigen::Vector2d::Zero()});
  Scenario scenario = building_scenario(options, track, floor, hand_held_carrier());
  add_lift(scenario.world, ride);
  return scenario;
}

}  // namespace lidar_mapping::simulation
