// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "path.hpp"
#include "terrain.hpp"

namespace lidar_mapping::simulation {

/// The point `left` metres to the left of a station.
Eigen::Vector2d beside(const Path& path, double station, double left);
/// Smallest distance from the path, to within a metre.
double distance_to(const Path& path, const Eigen::Vector2d& at);
/// The way back, `left` metres to the left of this one.
Path reversed(const Path& path, double left);

/// A paved strip of 2 `half_width` metres whose middle runs `left` metres beside the path.
void add_road_strip(TriangleMesh& mesh, const Terrain& terrain, const Path& path, double left,
                    double half_width);
/// Uneven grass just below the terrain's height.
void add_meadow(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, Random random);

}  // namespace lidar_mapping::simulation
