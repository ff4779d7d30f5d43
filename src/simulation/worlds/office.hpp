// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

// A floor of an office building: a ring of corridors around a core, with rooms outside of the ring.
// Dimensions, chosen as in usual office buildings.
/// Length of the middle line of the corridors along x, which begins at 0, m.
constexpr double kOfficeLength = 30.0;
constexpr double kOfficeWidth = 16.0;     ///< The same along y, m.
constexpr double kOfficeCorridor = 1.2;   ///< Half width of the corridors, m.
constexpr double kOfficeRoomDepth = 6.0;  ///< From the corridor to the outer wall, m.

/// Adds walls, rooms and furniture of the floor at z = 0.
void add_office(TriangleMesh& mesh, Random random);

}  // namespace lidar_mapping::simulation
