// SPDX-License-Identifier: BSD-3-Clause
#include "recent_scans.hpp"

namespace lidar_mapping::localization {

namespace {

/// m between scans that are kept: the default of key_frame_distance, so that a query is as dense as
/// one of loop closing.
constexpr double kSpacing = 2.0;
/// Scans before the newest one, as in submap_builder.hpp.
constexpr std::size_t kEarlier = 2;

}  // namespace

void RecentScans::add(const PointCloud& cloud, const Pose& T_odom_base,
                      const Eigen::Vector3d& p_base_lidar) {
  const bool is_apart =
      earlier_.empty() ||
      (newest_.T_odom_base.translation - earlier_.back().T_odom_base.translation).norm() > kSpacing;
  if (!newest_.points.empty() && is_apart) earlier_.push_back(std::move(newest_));
  if (earlier_.size() > kEarlier) earlier_.pop_front();
  newest_ = {loop_closing::VoxelMeans().filtered(cloud, map_leaf_), T_odom_base};
  p_base_lidar_ = p_base_lidar;
}

void RecentScans::clear() {
  earlier_.clear();
  newest_ = {};
}

loop_closing::PlaceQuery RecentScans::query() const {
  loop_closing::VoxelMeans voxels;
  voxels.reset(scan_leaf_);
  for (const Eigen::Vector3f& p : newest_.points) voxels.add(p);
  for (const RecentScan& scan : earlier_) {
    const Eigen::Isometry3f T =
        loop_closing::isometry(newest_.T_odom_base.inverse() * scan.T_odom_base);
    for (const Eigen::Vector3f& p : scan.points) voxels.add(T * p);
  }
  return {voxels.points(), newest_.points, p_base_lidar_};
}

}  // namespace lidar_mapping::localization
