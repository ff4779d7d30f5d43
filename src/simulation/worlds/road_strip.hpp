// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "motion/path.hpp"
#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// Point `left` metres to the left of a station.
Eigen::Vector2d beside(const Path& path, double station, double left);
/// Smallest distance of a point from the path, with an error of less than a metre.
double distance_to(const Path& path, const Eigen::Vector2d& at);
/// Path in the opposite direction, `left` metres to the left of this one.
Path reversed(const Path& path, double left);

/// Adds a paved strip of width 2 `half_width`, whose middle is `left` metres to the left of the
/// path.
void add_road_strip(TriangleMesh& mesh, const Terrain& terrain, const Path& path, double left,
                    double half_width);
/// Adds uneven grass just below the height of the terrain.
void add_meadow(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, Random random);

}  // namespace lidar_mapping::simulation
