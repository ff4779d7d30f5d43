// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "lidar_mapping/simulation/mesh.hpp"

#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// Adds the terrain between two corners as a grid of cells of `cell` metres.
void add_ground(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, double cell, Reflectivity reflectivity);

struct PatchColours {
  Reflectivity top;
  Reflectivity rim;
};
/// Adds the terrain within a quadrilateral, raised by `height` (m), with a vertical rim around it.
void add_raised_patch(TriangleMesh& mesh, const Terrain& terrain,
                      const std::array<Eigen::Vector2d, 4>& corners, double height,
                      PatchColours colours);
/// Pose of an object that stands on the terrain at `at`, tilted with it, with x along `yaw`.
Pose on_slope(const Terrain& terrain, const Eigen::Vector2d& at, double yaw);

}  // namespace lidar_mapping::simulation
