// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"

namespace lidar_mapping::pipeline {

/// The front end gets half of the threads, because the other stages need some, too.
front_end::FrontEndConfig with_threads(front_end::FrontEndConfig config, int threads);

/// Odometry of preprocessed scans: forwards each scan with its final result, in their order, and
/// reports what the front end warns of. One thread calls it.
class ScanMatching {
 public:
  /// Takes a scan in the LiDAR's frame and its final result.
  using Forward =
      std::function<void(const preprocessing::SyncedScan&, front_end::FrontEndResult&&)>;
  using Report = std::function<void(const std::string&)>;

  ScanMatching(const front_end::FrontEndConfig& config, Forward forward, Report report);

  /// Continues as FrontEnd::resume() does.
  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base);
  void add(const preprocessing::SyncedScan& synced);
  /// At the end: forwards provisional results.
  void flush();

 private:
  void report_status(const front_end::FrontEndStatus& status);
  void forward_finalized(std::vector<front_end::FrontEndResult>&& finalized);

  front_end::FrontEnd front_end_;
  Forward forward_;
  Report report_;
  bool has_begun_ = false;
  double elevation_shift_ = 0.0;        ///< Last value that was reported, rad.
  std::size_t map_points_dropped_ = 0;  ///< Last value that was reported.
  std::set<std::string> reported_;      ///< Keys of the other warnings that were reported.
  /// Scans whose results are provisional.
  std::vector<preprocessing::SyncedScan> provisional_scans_;
};

}  // namespace lidar_mapping::pipeline
