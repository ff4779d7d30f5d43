// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "lidar_mapping/simulation/mesh.hpp"

namespace lidar_mapping::simulation {

/// A moving object: one of the shapes of the world on a sampled path. Times are seconds after the
/// beginning of the drive; it exists only between its first and its last pose.
struct Mover {
  std::size_t shape = 0;          ///< Index into World::shapes.
  double begin_s = 0.0;           ///< Time of the first pose, s.
  double step_s = 0.1;            ///< Time between poses, s.
  std::vector<Pose> T_map_shape;  ///< Poses in the map frame.

  /// Interpolated pose; none while the object does not exist.
  std::optional<Pose> pose(double seconds) const {
    const double position = (seconds - begin_s) / step_s;
    if (position < 0.0 || position > static_cast<double>(T_map_shape.size()) - 1.0) return {};
    const auto before = static_cast<std::size_t>(position);
    if (before + 1 >= T_map_shape.size()) return T_map_shape.back();
    return interpolate(T_map_shape[before], T_map_shape[before + 1],
                       position - static_cast<double>(before));
  }
};

/// Everything that a ray can hit, in the map frame.
struct World {
  TriangleMesh fixed;                ///< Everything that does not move.
  std::vector<TriangleMesh> shapes;  ///< Shapes of moving objects, each in its own frame.
  std::vector<Mover> movers;         ///< Moving objects.

  /// Adds a moving object with a shape of its own; sets the mover's index of it.
  void add(TriangleMesh shape, Mover mover) {
    mover.shape = shapes.size();
    shapes.push_back(std::move(shape));
    movers.push_back(std::move(mover));
  }
};

}  // namespace lidar_mapping::simulation
