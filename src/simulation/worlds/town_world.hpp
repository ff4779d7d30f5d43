// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/world.hpp"

#include "worlds/terrain.hpp"
#include "worlds/town_layout.hpp"

namespace lidar_mapping::simulation {

/// Height of a pavement above the carriageway, m. Chosen as of usual kerbs.
constexpr double kKerbHeight = 0.12;
/// Distance of the middle of a lane from the middle of the street, m: lanes of 3.5 m, as by design
/// standards.
constexpr double kLaneOffset = 1.75;

/// The fixed world of a town: streets, blocks with houses and gardens, street furniture and parked
/// cars: those of the given day, of which the first (0) is that of the world itself.
TriangleMesh make_town_mesh(const TownLayout& layout, const Terrain& terrain, Random random,
                            std::uint64_t parking_day);

}  // namespace lidar_mapping::simulation
