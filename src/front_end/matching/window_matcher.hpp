// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/registration/registration.hpp"

#include "local_map/key_frame_window.hpp"

namespace lidar_mapping::front_end {

/// Aligns scans with a sliding window of key frames by any registration method.
class WindowMatcher {
 public:
  /// The result from the best of several starting poses; T_target_source is T_odom_base.
  struct Match {
    registration::RegistrationResult result;
    bool rescued = false;
  };

  explicit WindowMatcher(const FrontEndConfig& config);

  bool empty() const { return window_.empty(); }
  void clear() { window_.clear(); }
  /// Inserts a key frame, whose cloud is in base_link, into the window.
  void insert(const Pose& T_odom_base, PointCloud cloud);
  const Pose& newest_pose() const { return window_.newest_pose(); }
  /// The clouds of all key frames in odom.
  PointCloud cloud() const { return window_.joint_cloud(Pose::Identity()); }

  /// Aligns a scan from this pose.
  Match match(const PointCloud& scan, const Pose& T_odom_base_start);
  /// The best of this match and those from other starting poses.
  Match best_of(Match best, const PointCloud& scan, const std::vector<Pose>& starts);

 private:
  std::unique_ptr<registration::Registration> registration_;
  KeyFrameWindow window_;
  Pose T_odom_map_;  ///< frame of the registration's target
};

}  // namespace lidar_mapping::front_end
