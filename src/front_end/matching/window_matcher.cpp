// SPDX-License-Identifier: BSD-3-Clause
#include "matching/window_matcher.hpp"

#include <utility>

namespace lidar_mapping::front_end {

using registration::RegistrationResult;

WindowMatcher::WindowMatcher(const FrontEndConfig& config)
    : registration_(registration::make_registration(config.registration)),
      window_(static_cast<std::size_t>(config.local_frame_num),
              config.local_map_filter_resolution) {}

/// The target is relative to the newest key frame, so that single precision is sufficient far from
/// the start.
void WindowMatcher::insert(const Pose& T_odom_base, PointCloud cloud) {
  window_.push(T_odom_base, std::move(cloud));
  T_odom_map_ = T_odom_base;
  registration_->set_target(window_.joint_cloud(T_odom_map_.inverse()));
}

WindowMatcher::Match WindowMatcher::match(const PointCloud& scan, const Pose& T_odom_base_start) {
  RegistrationResult result = registration_->align(scan, T_odom_map_.inverse() * T_odom_base_start);
  result.T_target_source = T_odom_map_ * result.T_target_source;
  Match match;
  match.result = std::move(result);
  return match;
}

WindowMatcher::Match WindowMatcher::best_of(Match best, const PointCloud& scan,
                                            const std::vector<Pose>& starts) {
  for (const Pose& start : starts) {
    Match other = match(scan, start);
    if (other.result.inlier_fraction > best.result.inlier_fraction) {
      best = std::move(other);
      best.rescued = true;
    }
  }
  return best;
}

}  // namespace lidar_mapping::front_end
