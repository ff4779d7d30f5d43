// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"

namespace lidar_mapping::front_end {

/// What is known of a scan.
struct FrontEndResult {
  Stamp stamp = 0;  ///< that of the scan, bit for bit
  Pose T_odom_base;
  /// Of the motion since the previous scan, axes of base_link.
  Covariance6 covariance = Covariance6::Identity();
  /// Of base_link in its own axes, at the stamp: m/s, rad/s. With the scan in base_link,
  /// deskewed(cloud, twist, acceleration) gives it as it would have been seen at the stamp
  /// (deskew.hpp). The pose does not need that, so it is left to those who display the scan.
  Vector6d twist = Vector6d::Zero();
  Vector6d acceleration = Vector6d::Zero();  ///< change of the twist per second during the sweep
  /// If this scan was chosen. The first one is as soon as its points are deskewed or can be: where
  /// they have times, that is once the motion is known.
  std::optional<KeyFrame> key_frame;
  std::uint32_t segment = 0;  ///< poses of one segment of the trajectory hang together
  FrontEndStatus status;
  /// The scan will be looked at again, with more of its surroundings known: what it is now may do
  /// for those who cannot wait. So it is with the first scan, and with those after it for up to 6 s
  /// where a drive with few rings begins at speed. Key frames are chosen afterwards.
  bool provisional = false;
  /// The scans that were provisional until now, in their order, and as they are to stay.
  std::vector<FrontEndResult> finalized;
};

/// Odometry of a spinning LiDAR: matches each scan against a sliding window of key frames
/// (Magnusson 2009; doc/front_end.md). Scans are in the LiDAR's frame; what comes out is about
/// base_link, poses are T_odom_base at the scan's stamp. One thread calls it; it owns no clock and
/// no file.
class FrontEnd {
 public:
  explicit FrontEnd(const FrontEndConfig& config);
  ~FrontEnd();

  /// Throws InputError if the stamp does not increase. A poor match is no error: see the status.
  FrontEndResult process(const Scan& scan, const MotionPrior& prior = {});

  /// For the end of a drive, or where nothing comes for long: scans that are still provisional stay
  /// as they are.
  std::vector<FrontEndResult> finalize();

  /// How the LiDAR sits on the vehicle. Without it scans are taken to be in base_link, seen from
  /// nowhere in particular: the two sides of a thin plate are not told apart.
  void set_sensor_pose(const Pose& T_base_sensor);

  /// The first scan lies at this pose in odom, whatever other sensors say. Throws InputError if
  /// there was a scan already.
  void set_initial_pose(const Pose& T_odom_base);

  /// Goes on after a restart: the next scan begins a new segment, at this pose; the next key frame
  /// is `next_index`.
  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base);

  /// The clouds of the sliding window in odom, one point per voxel: for display.
  PointCloud local_map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::front_end
