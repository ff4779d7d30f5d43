// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// A house of `width` along its street and `depth` behind it. Its frame lies in the middle of the
/// front wall's foot, x along the street, y inwards. The cellar reaches `cellar` metres below.
struct HousePlan {
  double width = 12.0;
  double depth = 10.0;
  int floors = 3;
  double cellar = 1.0;
};

void add_house(TriangleMesh& mesh, const Pose& T_mesh_house, const HousePlan& plan, Random random);

}  // namespace lidar_mapping::simulation
