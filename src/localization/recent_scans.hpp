// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "lidar_mapping/loop_closing/place_verifier.hpp"

namespace lidar_mapping::localization {

/// The last scans that are some distance apart: together they are dense enough to be verified, also
/// those of a sensor with few beams.
class RecentScans {
 public:
  /// Edge of the voxels to which clouds are thinned: map_leaf_size and scan_leaf_size of loops, m.
  RecentScans(double map_leaf, double scan_leaf) : map_leaf_(map_leaf), scan_leaf_(scan_leaf) {}

  /// The newest scan in base_link, and its pose in a frame that odometry keeps.
  void add(const PointCloud& cloud, const Pose& T_odom_base, const Eigen::Vector3d& p_base_lidar);
  /// Removes all scans.
  void clear();
  /// The newest scan with those before it.
  loop_closing::PlaceQuery query() const;
  /// The newest scan alone, thinned as the key frames of the map.
  const loop_closing::Points& newest() const { return newest_.points; }

 private:
  struct RecentScan {
    loop_closing::Points points;
    Pose T_odom_base;
  };

  double map_leaf_;
  double scan_leaf_;
  RecentScan newest_;
  std::deque<RecentScan> earlier_;
  Eigen::Vector3d p_base_lidar_ = Eigen::Vector3d::Zero();
};

}  // namespace lidar_mapping::localization
