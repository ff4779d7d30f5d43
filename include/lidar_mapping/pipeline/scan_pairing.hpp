// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "lidar_mapping/pipeline/relative_odometry.hpp"

namespace lidar_mapping::pipeline {

/// A scan with its odometry.
struct PairedScan {
  /// The scan, and the motion since the one that was paired before.
  localization::LocalizerInput input;
  Pose T_odom_base;   ///< At the stamp of the scan.
  StatedTwist twist;  ///< At the stamp of the scan.
};

/// Pairs scans with odometry by equal stamps, whichever comes first. Scans that were lost on their
/// way leave no gap in the motion. One thread calls it.
class ScanPairing {
 public:
  /// Adds a step of odometry. One from before the newest discards those behind it: time went back.
  void add(const OdometryStep& step);
  /// Adds a scan.
  void add(Scan scan);
  /// The pairs that are complete, oldest first.
  std::vector<PairedScan> take_ready();
  /// Number of scans that were given up because no odometry came for them.
  std::size_t given_up() const { return given_up_; }

 private:
  PairedScan paired(Scan&& scan);

  std::map<Stamp, Scan> scans_;
  std::map<Stamp, OdometryStep> steps_;  ///< Since the scan that was paired last.
  RelativeOdometry motion_;
  std::size_t given_up_ = 0;
};

}  // namespace lidar_mapping::pipeline
