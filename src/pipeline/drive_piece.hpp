// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// What is kept of one scan.
struct ScanEntry {
  session::ScanRecord record;
  Pose T_odom_base;
  std::optional<GnssPosition> gnss;
  std::optional<ImuSample> imu;
};

/// The drive from behind one key frame to the next, which is the unit in which it goes from the
/// front end to the session.
struct DrivePiece {
  std::vector<ScanEntry> scans;                 ///< the last of them is the key frame's
  std::optional<KeyFrame> key_frame;            ///< none at the end of the drive
  loop_closing::PreparedKeyFrame prepared;      ///< for the loop search
  std::optional<Floor> floor;                   ///< at the key frame
  std::optional<GeodeticDatum> datum;           ///< where it is new
  std::optional<Eigen::Vector3d> p_base_lidar;  ///< where it is new
  std::vector<Loop> loops;                      ///< that the key frame closes
  std::vector<LoopVerdict> verdicts;
};

}  // namespace lidar_mapping::pipeline
