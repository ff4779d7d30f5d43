// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

// A floor of an office building: a ring of corridors around a core, with rooms outside of the ring.
/// Length of the middle line of the corridors along x, which begins at 0, m.
constexpr double kOfficeLength = 30.0;
constexpr double kOfficeWidth = 16.0;
constexpr double kOfficeCorridor = 1.2;  ///< Half width of the corridors, m.
constexpr double kOfficeRoomDepth = 6.0;

/// Adds walls, rooms and furniture of the floor at z = 0.
void add_office(TriangleMesh& mesh, Random& random);

}  // namespace lidar_mapping::simulation
