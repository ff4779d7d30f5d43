// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "track.hpp"

namespace lidar_mapping::simulation {

// A building of corridors one above the other along x, with stairs at their eastern end and a lift
// in the northern wall. The corridor of storey k lies at z = k * kStairStorey, y = 0 in its middle.
constexpr double kStairStorey = 3.2;  ///< m
constexpr int kStairStoreys = 4;
constexpr double kStairLane = 0.7;     ///< y of the flight that leads up; the other one: -y
constexpr double kFlightLength = 2.8;  ///< flights lie between x = 0 and this
constexpr double kHalfLanding = 3.5;   ///< x of its middle
constexpr double kMainLanding = -0.8;
constexpr double kCorridorEnd = -13.5;  ///< x
constexpr double kLiftX = -8.0;         ///< middle of the lift's door
constexpr double kLiftY = 2.65;         ///< middle of the lift's car

/// Walls, slabs, stairs and what stands in the corridors.
void add_stair_building(TriangleMesh& mesh, Random& random);
/// Height of the floor under each state of a track that begins in the corridor of storey 0.
std::vector<Ground> floor_in_stair_building(const Track& track);

/// The lift's car around x = y = 0 with its floor at z = 0; the door in the south is open.
TriangleMesh make_lift_car();
/// Closes the car's or a corridor's doorway when it stands at x = 0, y in the doorway.
TriangleMesh make_lift_door();

}  // namespace lidar_mapping::simulation
