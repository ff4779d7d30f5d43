// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <utility>

#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// A tracker whose first pose is another one than the origin.
class MovedTracker : public Tracker {
 public:
  /// `T_odom_start` is the frame of the given tracker.
  MovedTracker(std::unique_ptr<Tracker> tracker, const Pose& T_odom_start)
      : tracker_(std::move(tracker)), T_odom_start_(T_odom_start) {}

  TrackedScan track(const Scan& scan, const MotionPrior& prior) override {
    return moved(tracker_->track(scan, prior));
  }
  Covariance6 covariance_of_step(const TrackedScan& from, const TrackedScan& to) const override {
    return tracker_->covariance_of_step(from, to);
  }
  bool accepts_gyro(const MotionPrior& prior) const override {
    return tracker_->accepts_gyro(prior);
  }
  void set_viewpoint_at_origin() override { tracker_->set_viewpoint_at_origin(); }
  void restart() override {
    T_odom_start_ = Pose::Identity();
    tracker_->restart();
  }
  void finalize() override { tracker_->finalize(); }
  PointCloud local_map() const override {
    return transformed(tracker_->local_map(), T_odom_start_);
  }

  /// A result of the given tracker, as one of this tracker.
  TrackedScan moved(TrackedScan tracked) const {
    tracked.T_odom_base = T_odom_start_ * tracked.T_odom_base;
    for (Revision& revision : tracked.revisions)
      revision.T_odom_base = T_odom_start_ * revision.T_odom_base;
    return tracked;
  }

 private:
  std::unique_ptr<Tracker> tracker_;
  Pose T_odom_start_;
};

}  // namespace lidar_mapping::front_end
