// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

// A floor of an office: a corridor ring around a core, rooms outside of it.
constexpr double kOfficeLength = 30.0;  ///< of the corridor's middle line along x, from 0, m
constexpr double kOfficeWidth = 16.0;
constexpr double kOfficeCorridor = 1.2;  ///< half width
constexpr double kOfficeRoomDepth = 6.0;

/// The floor's walls, rooms and what stands in them, on z = 0.
void add_office(TriangleMesh& mesh, Random& random);

}  // namespace lidar_mapping::simulation
