// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Where a scan lies in the map, and how the vehicle moved at its stamp.
struct PlacedScan {
  Stamp stamp = 0;
  Pose T_map_base;
  /// Of base_link in its own axes: m/s, rad/s.
  Vector6d twist = Vector6d::Zero();
  Vector6d acceleration = Vector6d::Zero();  ///< change of the twist per second
  double elevation_shift = 0.0;              ///< rad, by which its points are to be turned upwards
};

/// All scans whose pose the session's odometry knows, by stamp. A scan is moved by the correction
/// of the key frames before and after it, in proportion to the time to them. Scans that are
/// lost or came again are left out, and those between two segments, of which nobody knows how they
/// hang together. `poses` are those of the key frames; twists come from the odometry of the scans
/// before and after.
std::vector<PlacedScan> placed_scans(const session::Session& session, const KeyFramePoses& poses);

}  // namespace lidar_mapping::pipeline
