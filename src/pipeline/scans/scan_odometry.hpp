// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "lidar_mapping/preprocessing/floor_detector.hpp"

#include "drive_chunk.hpp"
#include "resume_point.hpp"
#include "scans/scan_matching.hpp"
#include "scans/scan_preparation.hpp"

namespace lidar_mapping::pipeline {

/// Turns scans into chunks of the drive with odometry and key frames. One thread calls it.
class ScanOdometry {
 public:
  using Forward = std::function<void(DriveChunk&&)>;

  using Report = std::function<void(const std::string&)>;

  ScanOdometry(const front_end::FrontEndConfig& front_end,
               const preprocessing::FloorDetectionConfig& floor, Forward forward, Report report);

  /// Resumes a session.
  void resume(const ResumePoint& point);
  void add(const PreparedScan& prepared);
  /// At the end: forwards provisional results, and the scans after the last key frame.
  void flush();

 private:
  void add(const preprocessing::SyncedScan& synced, front_end::FrontEndResult&& result);
  void forward_chunk();

  ScanMatching matching_;
  preprocessing::FloorDetector floor_detector_;
  Forward forward_;
  std::optional<ResumedOdometry> resumed_;
  DriveChunk chunk_;
};

}  // namespace lidar_mapping::pipeline
