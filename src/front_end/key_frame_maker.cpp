// SPDX-License-Identifier: BSD-3-Clause
#include "key_frame_maker.hpp"

#include <memory>
#include <utility>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/front_end/deskew.hpp"

namespace lidar_mapping::front_end {
namespace {

/// A scan that is probably wrong becomes a key frame only if no better one follows within this
/// multiple of the usual distance. Chosen: a wider gap leaves a hole in the map.
constexpr double kDegradedKeyFrameFactor = 3.0;

PointCloud selected(const PointCloud& cloud, const std::vector<std::uint32_t>& indices) {
  PointCloud result;
  result.points.reserve(indices.size());
  for (const std::uint32_t i : indices) result.points.push_back(cloud.points[i]);
  if (!cloud.has_times()) return result;
  result.times.reserve(indices.size());
  for (const std::uint32_t i : indices) result.times.push_back(cloud.times[i]);
  return result;
}

}  // namespace

KeyFrameMaker::KeyFrameMaker(const FrontEndConfig& config)
    : resolution_(config.key_frame_cloud_resolution),
      threads_(config.threads),
      rule_{config.key_frame_distance, config.key_frame_angle, config.key_frame_interval},
      degraded_rule_(rule_.scaled(kDegradedKeyFrameFactor)) {}

void KeyFrameMaker::add_step(const TrackedScan& from, const TrackedScan& to) {
  inflation_.add_step(from.T_odom_base.inverse() * to.T_odom_base, to.status);
}

void KeyFrameMaker::start_segment() {
  last_.reset();
  reset_steps();
}

void KeyFrameMaker::resume(KeyFrameIndex next_index) {
  start_segment();
  next_index_ = next_index;
}

bool KeyFrameMaker::is_due(Stamp stamp, bool has_times, const TrackedScan& tracked) const {
  if (tracked.status.state == TrackingState::kLost) return false;
  // The distortion of such a key frame would be permanent, and would disturb every loop to it.
  if (has_times && !tracked.motion_known) return false;
  const KeyFrameRule& rule =
      tracked.status.state == TrackingState::kDegraded ? degraded_rule_ : rule_;
  return !last_ ||
         rule.reached(last_->T_odom_base.inverse() * tracked.T_odom_base, stamp - last_stamp_);
}

PointCloud KeyFrameMaker::points_of(const PointCloud& cloud, const TrackedScan& tracked) {
  PointCloud points = thinned(cloud);
  rotate_upwards(points, tracked.correction.elevation_shift);
  return points;
}

PointCloud KeyFrameMaker::thinned(const PointCloud& cloud) {
  if (resolution_ <= 0.0) return cloud;
  SamplingOptions options;
  options.resolution = resolution_;
  return selected(cloud, sampler_.sample(cloud, options));
}

KeyFrame KeyFrameMaker::make(Stamp stamp, std::uint32_t segment, const TrackedScan& tracked,
                             PointCloud points, const Tracker& tracker) {
  KeyFrame key_frame;
  key_frame.index = next_index_++;
  key_frame.segment = segment;
  key_frame.stamp = stamp;
  key_frame.T_odom_base = tracked.T_odom_base;
  if (last_) {
    key_frame.motion_covariance = tracker.covariance_of_step(*last_, tracked);
    inflation_.apply_to(key_frame);
  }
  reset_steps();
  key_frame.degenerate_directions = tracked.status.degenerate_directions;
  key_frame.cloud = std::make_shared<const PointCloud>(
      deskewed(std::move(points), tracked.twist, tracked.acceleration, threads_));
  last_ = tracked;
  last_stamp_ = stamp;
  return key_frame;
}

}  // namespace lidar_mapping::front_end
