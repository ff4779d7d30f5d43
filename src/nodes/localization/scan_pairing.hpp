// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::ros_border {

/// What an odometry says at the stamp of a scan.
struct OdometryStep {
  Stamp stamp = 0;
  Pose T_odom_base;
  /// Of the motion since the previous step, in the axes of base_link; none where odometry does not
  /// lead here from there.
  std::optional<Covariance6> covariance;
};

/// A scan with its odometry, and the motion since the scan that was paired before.
struct PairedScan {
  Scan scan;
  Pose T_odom_base;
  Pose T_previous_base;
  Covariance6 covariance = Covariance6::Zero();  ///< of T_previous_base, in the axes of base_link
  bool is_connected = false;  ///< odometry leads here from the scan that was paired before
};

/// Pairs scans with odometry by equal stamps, whichever comes first. Scans that were lost on their
/// way leave no gap in the motion. One thread calls it.
class ScanPairing {
 public:
  void add(const OdometryStep& step);
  void add(Scan scan);
  /// The pairs that are complete, oldest first.
  std::vector<PairedScan> take_ready();
  /// Scans that were given up because no odometry came for them.
  std::size_t given_up() const { return given_up_; }

 private:
  PairedScan paired(Scan&& scan);

  std::map<Stamp, Scan> scans_;
  std::map<Stamp, OdometryStep> steps_;  ///< since the scan that was paired last
  std::optional<Pose> T_odom_last_;      ///< of that scan
  std::size_t given_up_ = 0;
};

}  // namespace lidar_mapping::ros_border
