// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// Adds the parked cars of a day, each of which `park(mesh, random)` adds: on day 0 those of the
/// world itself. The numbers of these are drawn on every day, so that all but the cars is the same.
template <typename Park>
void add_parked_cars(TriangleMesh& mesh, Random& random, std::uint64_t day, const Park& park) {
  Random before = random;
  TriangleMesh unused;
  park(day == 0 ? mesh : unused, random);
  if (day == 0) return;
  Random of_day(before.bits(), day);
  park(mesh, of_day);
}

}  // namespace lidar_mapping::simulation
