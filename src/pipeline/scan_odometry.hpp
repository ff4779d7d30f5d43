// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/preprocessing/floor_detector.hpp"

#include "drive_chunk.hpp"
#include "resume_point.hpp"
#include "scan_preparation.hpp"

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
  void report_status(const front_end::FrontEndStatus& status);
  void add_finalized(std::vector<front_end::FrontEndResult>&& finalized);
  void add(const preprocessing::SyncedScan& synced, front_end::FrontEndResult&& result);
  void record(const preprocessing::SyncedScan& synced, const front_end::FrontEndResult& result);
  void forward_chunk();

  front_end::FrontEnd front_end_;
  preprocessing::FloorDetector floor_detector_;
  Forward forward_;
  Report report_;
  std::optional<ResumedOdometry> resumed_;
  bool has_begun_ = false;
  double elevation_shift_ = 0.0;        ///< Last value that was reported, rad.
  std::size_t map_points_dropped_ = 0;  ///< Last value that was reported.
  std::set<std::string> reported_;      ///< Keys of the other warnings that were reported.
  /// Scans whose results are provisional.
  std::vector<preprocessing::SyncedScan> provisional_scans_;
  DriveChunk chunk_;
};

}  // namespace lidar_mapping::pipeline
