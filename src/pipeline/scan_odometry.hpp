// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/preprocessing/floor_detector.hpp"

#include "drive_piece.hpp"
#include "resume_point.hpp"
#include "scan_preparation.hpp"

namespace lidar_mapping::pipeline {

/// From scans to pieces of the drive. One thread calls it.
class ScanOdometry {
 public:
  using Forward = std::function<void(DrivePiece&&)>;

  using Say = std::function<void(const std::string&)>;

  ScanOdometry(const front_end::FrontEndConfig& front_end,
               const preprocessing::FloorDetectionConfig& floor, Forward forward, Say say);

  /// Goes on with a session.
  void resume(const ResumePoint& point);
  void take(const PreparedScan& prepared);
  /// At the end: sends on what waited, and the scans behind the last key frame.
  void flush();

 private:
  void mention(const front_end::FrontEndStatus& status);
  void add_finalized(std::vector<front_end::FrontEndResult>&& finalized);
  void take(const preprocessing::SyncedScan& synced, front_end::FrontEndResult&& result);
  void record(const preprocessing::SyncedScan& synced, const front_end::FrontEndResult& result);
  void send();

  front_end::FrontEnd front_end_;
  preprocessing::FloorDetector floor_detector_;
  Forward forward_;
  Say say_;
  std::optional<ResumedOdometry> resumed_;
  bool has_begun_ = false;
  double elevation_shift_ = 0.0;        ///< that was last spoken of
  std::size_t map_points_dropped_ = 0;  ///< the same
  bool jitter_mentioned_ = false;
  bool gyro_mentioned_ = false;
  bool ride_mentioned_ = false;
  std::vector<preprocessing::SyncedScan> held_;  ///< those whose result is provisional
  DrivePiece piece_;
};

}  // namespace lidar_mapping::pipeline
