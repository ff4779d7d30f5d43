// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/localization/localizer.hpp"

namespace lidar_mapping::pipeline {

/// A twist of base_link in its own axes (m/s, rad/s) with its covariance; a covariance of zero is
/// not known.
struct StatedTwist {
  Vector6d value = Vector6d::Zero();             ///< Translation before rotation.
  Covariance6 covariance = Covariance6::Zero();  ///< Of `value`.
};

/// What an odometry says at the stamp of a scan.
struct OdometryStep {
  Stamp stamp = 0;   ///< That of the scan.
  Pose T_odom_base;  ///< Pose at that stamp.
  /// Of the motion since the previous step, in the axes of base_link; none where odometry does not
  /// lead here from there.
  std::optional<Covariance6> covariance;
  StatedTwist twist = {};  ///< At that stamp.
};

/// Adds up the steps of odometry from one scan that is localised to the next, also where scans in
/// between were lost. One thread calls it.
class RelativeOdometry {
 public:
  /// Adds the next step.
  void add(const OdometryStep& step);
  /// Steps were lost: odometry does not lead to the next scan.
  void interrupt() { is_connected_ = false; }
  /// Takes the scan of the newest step; the motion is that since the scan that was taken before.
  /// The caller sets the position of the LiDAR.
  localization::LocalizerInput input_of(Scan&& scan);

 private:
  Pose T_odom_newest_;                            ///< Of the newest step.
  Pose T_odom_last_;                              ///< Of the scan that was taken last.
  Covariance6 covariance_ = Covariance6::Zero();  ///< Of the motion between these.
  bool is_connected_ = false;  ///< Odometry leads from that scan to the newest step.
};

}  // namespace lidar_mapping::pipeline
