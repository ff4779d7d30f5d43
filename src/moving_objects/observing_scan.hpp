// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/moving_objects/local_ground.hpp"
#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include "range_image.hpp"

namespace lidar_mapping::moving_objects {

/// A key frame as an observer: what it saw, from where.
struct ObservingScan {
  Pose T_sensor_map;
  RangeImage image;
  std::vector<GroundColumn> ground;
};

/// What the observers say of a point.
enum class Vote : char { kStands, kMoves, kUnseen };

/// The observers' verdict on the points of a key frame with those numbers; the others are unseen.
/// The order of asking does not matter: an observer is left out only where it could change nothing.
std::vector<Vote> votes_on(const PointCloud& cloud, const Pose& T_map_base,
                           const std::vector<std::uint32_t>& asked,
                           const std::vector<const ObservingScan*>& observers,
                           const MovingObjectsConfig& config);

}  // namespace lidar_mapping::moving_objects
