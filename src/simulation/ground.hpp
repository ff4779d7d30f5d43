// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "lidar_mapping/simulation/mesh.hpp"

#include "terrain.hpp"

namespace lidar_mapping::simulation {

/// The terrain between two corners as a grid of cells of `cell` metres.
void add_ground(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, double cell, Reflectivity reflectivity);

struct PatchColours {
  Reflectivity top;
  Reflectivity rim;
};
/// The terrain within a quadrilateral, raised by `height`, with an upright rim around it.
void add_raised_patch(TriangleMesh& mesh, const Terrain& terrain,
                      const std::array<Eigen::Vector2d, 4>& corners, double height,
                      PatchColours colours);
/// Pose of a thing that stands on the terrain at `at`, tilted with it, x along `yaw`.
Pose on_slope(const Terrain& terrain, const Eigen::Vector2d& at, double yaw);

}  // namespace lidar_mapping::simulation
