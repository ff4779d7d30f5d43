// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::map_quality {

/// A point with the direction of the ray that measured it.
struct ObservedPoint {
  Eigen::Vector3d position;  ///< m, relative to the centre of the section.
  Eigen::Vector3d beam;      ///< From the LiDAR to the point, m; zero if unknown.
};

using ObservedPoints = std::vector<ObservedPoint>;
/// Translation (m), then yaw (rad) about the centre of the section.
using Shift = Eigen::Vector4d;

/// Result of the registration of two passes.
struct PassShift {
  Shift shift = Shift::Zero();     ///< Of the later pass against the earlier one.
  std::size_t planes = 0;          ///< Number of planes that were matched.
  std::size_t agreeing_walls = 0;  ///< Number of walls that agree with the shift.
  double residual = 0.0;           ///< Median distance of the planes after the registration, m.

  /// False if too few planes were matched for four unknowns.
  bool is_known() const;
};

/// Registers the later pass onto the earlier one by the planes that both have. Surfaces match only
/// if they were observed from the same side; `sided` is false if the sides are unknown.
PassShift register_passes(const ObservedPoints& earlier, const ObservedPoints& later, bool sided);

}  // namespace lidar_mapping::map_quality
