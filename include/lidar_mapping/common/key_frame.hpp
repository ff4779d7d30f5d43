// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping {

/// Number of a key frame in a run; it continues after a restart of the front end.
using KeyFrameIndex = std::uint32_t;

/// A scan that was chosen for the map. Only the front end creates and numbers key frames.
struct KeyFrame {
  KeyFrameIndex index = 0;    ///< its number in the run
  std::uint32_t segment = 0;  ///< no odometry constraint joins two segments
  Stamp stamp = 0;            ///< of the scan
  Pose T_odom_base;           ///< by odometry, at the stamp
  /// Of the motion since the previous key frame, in the axes of base_link at this one.
  Covariance6 motion_covariance = Covariance6::Identity();
  std::vector<Eigen::Vector3d> degenerate_directions;  ///< in base_link, unit length
  /// A step of that motion may be wrong by more than the covariance of its match; motion_covariance
  /// contains the expected error.
  bool doubtful = false;
  PointCloudPtr cloud;  ///< in base_link, deskewed to the stamp; null where it is stored elsewhere
};

/// A key frame and the run that it belongs to.
struct RunKeyFrame {
  std::string run_id;  ///< names the run
  KeyFrame key_frame;  ///< with or without its cloud
};

/// Pose of a key frame in the map.
struct KeyFramePose {
  KeyFrameIndex index = 0;  ///< that of the key frame
  Stamp stamp = 0;          ///< that of the key frame
  Pose T_map_base;          ///< newest estimate of the back end
};

/// All poses (whole), or those that are new or moved, ordered by index.
struct KeyFramePoses {
  std::uint32_t revision = 0;       ///< grows whenever poses have moved
  bool whole = true;                ///< all key frames of the run are listed
  std::vector<KeyFramePose> poses;  ///< increasing index
  std::uint32_t since = 0;          ///< of a part: revision whose poses the others still have
};

}  // namespace lidar_mapping
