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

/// What the session stores of one scan.
struct ScanEntry {
  session::ScanRecord record;
  Pose T_odom_base;
  std::optional<GnssPosition> gnss;
  std::optional<ImuSample> imu;
};

/// A chunk of the drive: all scans after one key frame up to the next, which are passed from the
/// front end to the session together.
struct DriveChunk {
  std::vector<ScanEntry> scans;                 ///< The last one is the scan of the key frame.
  std::optional<KeyFrame> key_frame;            ///< None at the end of the drive.
  loop_closing::PreparedKeyFrame prepared;      ///< The key frame prepared for the loop search.
  std::optional<Floor> floor;                   ///< Floor at the stamp of the key frame.
  std::optional<GeodeticDatum> datum;           ///< Set where it is new.
  std::optional<Eigen::Vector3d> p_base_lidar;  ///< Set where it is new, m.
  std::vector<Loop> loops;                      ///< Loops that the key frame closes.
  std::vector<LoopVerdict> verdicts;
};

}  // namespace lidar_mapping::pipeline
