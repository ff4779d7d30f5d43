// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"
#include "lidar_mapping/front_end/point_correction.hpp"

namespace lidar_mapping::front_end {

/// The result for one scan.
struct FrontEndResult {
  Stamp stamp = 0;   ///< the scan's stamp, unchanged
  Pose T_odom_base;  ///< at the stamp
  /// Covariance of the motion since the previous scan, in the axes of base_link.
  Covariance6 covariance = Covariance6::Identity();
  /// Twist of base_link in its own axes at the stamp: m/s, rad/s. By it corrected_cloud()
  /// (corrected_cloud.hpp) gives the scan without motion distortion. The pose does not need this
  /// step, so it is left to those who use the scan.
  Vector6d twist = Vector6d::Zero();
  /// Change of the twist during the sweep: m/s^2, rad/s^2.
  Vector6d acceleration = Vector6d::Zero();
  PointCorrection correction;  ///< how the points of the scan were changed before matching
  /// Set if this scan was chosen as a key frame. The first scan is chosen as soon as its points are
  /// deskewed or can be deskewed: if the points have times, this is when the motion is known.
  std::optional<KeyFrame> key_frame;
  std::uint32_t segment = 0;  ///< poses within one segment are connected by odometry
  FrontEndStatus status;      ///< how good the match is
  /// The scan will be matched again when the map holds more of its surroundings. Use this result
  /// only if you cannot wait for the final one. The first scan is provisional; if a drive begins at
  /// speed and the sensor has few rings, so are the scans of the next 6 s at most. Their key frames
  /// are chosen afterwards.
  bool provisional = false;
  /// The scans that were provisional until now, in their order, with their final results.
  std::vector<FrontEndResult> finalized;
};

/// Odometry of a spinning LiDAR: matches each scan against a map of its recent surroundings, by
/// default by a sequential NDT (Magnusson 2009; doc/front_end.md). The scans are in the LiDAR's
/// frame. The results are about base_link; poses are T_odom_base at the scan's stamp. The class
/// must be called from one thread; it uses no clock and no files.
class FrontEnd {
 public:
  /// Begins a run with an empty map. The configuration is one that load() accepts.
  explicit FrontEnd(const FrontEndConfig& config);
  ~FrontEnd();

  /// Odometry of one scan. Throws InputError if the stamp does not increase. A poor match is not an
  /// error: it is reported in the status.
  FrontEndResult process(const Scan& scan, const MotionPrior& prior = {});

  /// Makes all provisional scans final as they are. To be called at the end of a drive, or if no
  /// scan arrives for a long time.
  std::vector<FrontEndResult> finalize();

  /// The pose of the LiDAR on the vehicle. If it is not set, the scans are taken to be in base_link
  /// and the viewpoint is unknown: the two sides of a thin plate are then not distinguished.
  void set_sensor_pose(const Pose& T_base_sensor);

  /// Sets the pose of the first scan in odom; it overrides the values of other sensors. Throws
  /// InputError if a scan was processed already.
  void set_initial_pose(const Pose& T_odom_base);

  /// Continues after a restart of the program: the next scan begins a new segment at this pose,
  /// whatever other sensors measure, and the next key frame has the index `next_index`.
  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base);

  /// Covariance of the newest T_odom_base of process(), in the axes of base_link: that of all steps
  /// since the first scan, as if their errors were independent.
  Covariance6 pose_covariance() const;

  /// The clouds of the sliding window in odom, with one point per voxel. For display.
  PointCloud local_map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::front_end
