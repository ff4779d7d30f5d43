// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "motion/track.hpp"

namespace lidar_mapping::simulation {

// A building whose corridors lie one above the other along x, with stairs at the eastern end and a
// lift in the northern wall. The corridor of storey k is at z = k * kStairStorey, its middle at y =
// 0. Dimensions (m), chosen as in usual buildings.
constexpr double kStairStorey = 3.2;  ///< m
constexpr int kStairStoreys = 4;
/// y of the flights that lead up from a storey; the others are at -y. Chosen, like those below, so
/// that stairs and lift fit into the building.
constexpr double kStairLane = 0.7;
constexpr double kFlightLength = 2.8;   ///< The flights lie between x = 0 and this.
constexpr double kHalfLanding = 3.5;    ///< x of the middle of the half landing.
constexpr double kMainLanding = -0.8;   ///< x of the middle of the main landing.
constexpr double kCorridorEnd = -13.5;  ///< x of its western end.
constexpr double kLiftX = -8.0;         ///< x of the middle of the lift's door.
constexpr double kLiftY = 2.65;         ///< y of the middle of the lift's car.

/// Adds walls, slabs, stairs and the furniture of the corridors.
void add_stair_building(TriangleMesh& mesh, Random random);
/// Ground under each state of a track that begins in the corridor of storey 0.
std::vector<Ground> floor_in_stair_building(const Track& track);

/// The car of the lift around x = y = 0 with its floor at z = 0; its doorway in the south is open.
TriangleMesh make_lift_car();
/// A door that closes the doorway of the car or of a corridor at x = 0 and y in the doorway.
TriangleMesh make_lift_door();

}  // namespace lidar_mapping::simulation
