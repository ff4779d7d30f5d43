// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// Plan of a house of `width` along its street and `depth` behind it, m. The origin of its frame is
/// the middle of the foot of the front wall; x points along the street, y inwards. The walls reach
/// `cellar` metres below the ground.
struct HousePlan {
  double width = 12.0;
  double depth = 10.0;
  int floors = 3;
  double cellar = 1.0;
};

void add_house(TriangleMesh& mesh, const Pose& T_mesh_house, const HousePlan& plan, Random random);

}  // namespace lidar_mapping::simulation
