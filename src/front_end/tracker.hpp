// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"

namespace lidar_mapping::front_end {

/// What was found of a provisional scan when it was looked at again.
struct Revision {
  Pose T_odom_base;
  Covariance6 covariance = Covariance6::Identity();
  double drift_variance_factor = 1.0;
  Vector6d twist = Vector6d::Zero();
  Vector6d acceleration = Vector6d::Zero();
  std::vector<Eigen::Vector3d> degenerate_directions;
};

/// Where a tracker believes one scan to be. All of it is about the frame of the scans that the
/// tracker is given, the LiDAR's (BaseFrame): that is its `base`, and lies in its `odom` where it
/// was first.
struct TrackedScan {
  Pose T_odom_base;  ///< at the scan's stamp
  /// Of T_odom_base against the local map, axes of base_link.
  Covariance6 covariance = Covariance6::Identity();
  /// Variance of errors that part as the sensor moves on, in units of the usual.
  double drift_variance_factor = 1.0;
  Vector6d twist = Vector6d::Zero();  ///< of base_link in its own axes, at the stamp: m/s, rad/s
  Vector6d acceleration = Vector6d::Zero();  ///< change of the twist per second during the sweep
  FrontEndStatus status;
  double elevation_shift = 0.0;  ///< by which the scan's points were turned upwards, rad
  /// False while the twist is a guess, as at the first scan of a drive: a sweep cannot be deskewed.
  bool motion_known = true;
  /// The local map was given up and begun anew: this pose does not hang together with earlier ones.
  bool new_segment = false;
  /// True for the first scans of a map, as long as they may be looked at again.
  bool provisional = false;
  /// Of the first of the scans that were provisional until now, in their order; the others stay.
  std::vector<Revision> revisions;
};

/// Follows the sensor from scan to scan: predicts, matches against its local map, and puts into
/// that map what it trusts. FrontEnd does the rest (stamps, segments, key frames).
class Tracker {
 public:
  virtual ~Tracker() = default;

  /// Stamps increase from call to call. Never throws for what the world did: see the status.
  virtual TrackedScan track(const Scan& scan, const MotionPrior& prior) = 0;
  /// False where the scan is to be seen as it was before a gyro had its say.
  virtual bool accepts_gyro(const MotionPrior& /*prior*/) const { return true; }
  /// Scans are seen from their origin.
  virtual void set_viewpoint_at_origin() {}
  /// Forgets all; the next scan is the first one of a new local map and lies at its origin.
  virtual void restart() = 0;
  /// What is provisional stays as it is.
  virtual void finalize() {}
  /// The local map in odom, one point per voxel: for display.
  virtual PointCloud local_map() const = 0;
};

/// The tracker for config.registration: the sequential NDT, or a sliding window of key frames
/// matched by any other method.
std::unique_ptr<Tracker> make_tracker(const FrontEndConfig& config);

}  // namespace lidar_mapping::front_end
