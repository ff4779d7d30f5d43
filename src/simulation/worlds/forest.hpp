// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// Adds trunks, undergrowth, boulders and fallen logs on the terrain around a path; nothing is
/// nearer to the path than `clear` metres.
void add_forest(TriangleMesh& mesh, const Terrain& terrain,
                const std::vector<Eigen::Vector2d>& path, double clear, Random random);

}  // namespace lidar_mapping::simulation
