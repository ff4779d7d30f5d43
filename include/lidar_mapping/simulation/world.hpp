// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lidar_mapping/simulation/mesh.hpp"

namespace lidar_mapping::simulation {

/// A thing that moves: one of the world's shapes on a sampled way. Times are seconds after the
/// drive's beginning; it exists only between its first and its last pose.
struct Mover {
  std::size_t shape = 0;
  double begin_s = 0.0;
  double step_s = 0.1;
  std::vector<Pose> T_map_shape;

  /// Interpolated pose, or nothing while the mover is not there.
  std::optional<Pose> pose(double seconds) const;
};

/// All that a ray can hit, in map.
struct World {
  TriangleMesh fixed;
  std::vector<TriangleMesh> shapes;
  std::vector<Mover> movers;
};

}  // namespace lidar_mapping::simulation
