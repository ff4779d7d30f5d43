// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Pose of a scan in the map, and the motion of the vehicle at its stamp.
struct ScanPose {
  Stamp stamp = 0;  ///< Stamp of the scan, ns.
  Pose T_map_base;  ///< Pose of base_link at the stamp.
  /// Linear and angular velocity of base_link in its own axes, m/s and rad/s.
  Vector6d twist = Vector6d::Zero();
  Vector6d acceleration = Vector6d::Zero();  ///< Derivative of the twist, m/s^2 and rad/s^2.
  double elevation_shift = 0.0;  ///< Angle by which its points have to be rotated upwards, rad.
};

/// All scans whose pose the odometry of the session knows, by stamp. A scan is moved by the
/// corrections of the key frames of its drive before and after it, weighted by the time to them.
/// Scans that are lost or repeated are left out, and so are those between two segments, whose
/// relative pose is unknown. `poses` are those of the key frames; twists follow from the odometry
/// of the neighbouring scans.
std::vector<ScanPose> scan_poses(const session::Session& session, const KeyFramePoses& poses);

}  // namespace lidar_mapping::pipeline
