// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"
#include "lidar_mapping/front_end/point_correction.hpp"

namespace lidar_mapping::front_end {

/// The result for a provisional scan after it was matched again.
struct Revision {
  Pose T_odom_base;
  Covariance6 covariance = Covariance6::Identity();
  double drift_variance_factor = 1.0;
  Vector6d twist = Vector6d::Zero();
  Vector6d acceleration = Vector6d::Zero();
  std::vector<Eigen::Vector3d> degenerate_directions;
};

/// A pose with its uncertainty, at the stamp of its scan.
struct PoseEstimate {
  Pose T_odom_base;
  /// Covariance of T_odom_base relative to the local map, axes of base_link.
  Covariance6 covariance = Covariance6::Identity();
  /// Variance of the errors that become different between scans while the sensor moves on, as a
  /// multiple of the usual one.
  double drift_variance_factor = 1.0;
  /// Covariance of the pose within its sweep, in addition: independent from scan to scan.
  Covariance6 sweep_covariance = Covariance6::Zero();
};

/// The result of a tracker for one scan. All values refer to the frame of the scans that the
/// tracker is given, which is the LiDAR's frame (BaseFrame): here it is called `base`, and `odom`
/// is its first pose.
struct TrackedScan : PoseEstimate {
  Vector6d twist = Vector6d::Zero();  ///< of base_link in its own axes, at the stamp: m/s, rad/s
  Vector6d acceleration = Vector6d::Zero();  ///< change of the twist per second during the sweep
  FrontEndStatus status;
  PointCorrection correction;  ///< of the scan's points
  /// False while the twist is only assumed, as at the first scan of a drive: then a sweep cannot be
  /// deskewed.
  bool motion_known = true;
  /// The local map was discarded and started again: this pose is not connected with earlier ones.
  bool new_segment = false;
  /// True for the first scans of a map, as long as they may be matched again.
  bool provisional = false;
  /// New results for the first of the scans that were provisional until now, in their order; the
  /// other provisional scans keep their results.
  std::vector<Revision> revisions;
};

/// Tracks the sensor from scan to scan: predicts its pose, matches the scan against the local map,
/// and inserts reliable scans into that map. SensorOdometry does the rest (stamps, segments, key
/// frames).
class Tracker {
 public:
  virtual ~Tracker() = default;

  /// Stamps increase from call to call. The method does not throw because of poor data: see the
  /// status.
  virtual TrackedScan track(const Scan& scan, const MotionPrior& prior) = 0;
  /// Covariance of the motion from one tracked scan to a later one, in the axes of the latter.
  virtual Covariance6 covariance_of_step(const TrackedScan& from, const TrackedScan& to) const;
  /// False if the scan must be processed without the gyro's correction.
  virtual bool accepts_gyro(const MotionPrior& /*prior*/) const { return true; }
  /// Tells the tracker that scans are measured from the origin of their frame.
  virtual void set_viewpoint_at_origin() {}
  /// Discards everything; the next scan is the first one of a new local map and lies at its origin.
  virtual void restart() = 0;
  /// Makes the provisional scans final as they are.
  virtual void finalize() {}
  /// The local map in odom, one point per voxel: for display.
  virtual PointCloud local_map() const = 0;
};

/// The tracker for the configuration: an external odometry, the sequential NDT, or a sliding window
/// of key frames matched by any other method.
std::unique_ptr<Tracker> make_tracker(const FrontEndConfig& config);
/// True if that is the sequential NDT.
bool is_sequential_ndt(const FrontEndConfig& config);

}  // namespace lidar_mapping::front_end
