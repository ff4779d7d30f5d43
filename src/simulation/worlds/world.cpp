// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/world.hpp"

#include <utility>

namespace lidar_mapping::simulation {

std::optional<Pose> Mover::pose(double seconds) const {
  const double position = (seconds - begin_s) / step_s;
  if (position < 0.0 || position > static_cast<double>(T_map_shape.size()) - 1.0) return {};
  const auto before = static_cast<std::size_t>(position);
  if (before + 1 >= T_map_shape.size()) return T_map_shape.back();
  return interpolate(T_map_shape[before], T_map_shape[before + 1],
                     position - static_cast<double>(before));
}

void World::add(TriangleMesh shape, Mover mover) {
  mover.shape = shapes.size();
  shapes.push_back(std::move(shape));
  movers.push_back(std::move(mover));
}

}  // namespace lidar_mapping::simulation
