// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// Shapes that stand on z = 0 around their origin, with x forward.
TriangleMesh make_car(Random random);
TriangleMesh make_van(Random random);
TriangleMesh make_pedestrian(Random random);

}  // namespace lidar_mapping::simulation
