// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/moving_objects/local_ground.hpp"
#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include "visibility/range_image.hpp"

namespace lidar_mapping::moving_objects {

/// A key frame as an observer: what it observed, and from where.
struct ObservingScan {
  Pose T_sensor_map;
  RangeImage image;
  std::vector<GroundColumn> ground;
};

/// Vote of the observers on a point.
enum class Vote : char { kStatic, kMoving, kUnseen };

/// Votes of the observers on the points of a key frame with these indices; all other points are
/// unobserved. The result does not depend on the order of the observers: one is skipped only if it
/// cannot change the vote.
std::vector<Vote> collect_votes(const PointCloud& cloud, const Pose& T_map_base,
                                const std::vector<std::uint32_t>& indices,
                                const std::vector<const ObservingScan*>& observers,
                                const MovingObjectsConfig& config);

}  // namespace lidar_mapping::moving_objects
