// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// Scan against a window of the last key frames, with any registration method: key frames are
/// joined and thinned out to one target whenever a new one enters the window, scans are thinned out
/// and aligned from a prediction of constant velocity. The scheme of the articles
/// (doc/front_end.md); made for comparing methods, as the target is built anew each time.
class SlidingWindowTracker : public Tracker {
 public:
  explicit SlidingWindowTracker(const FrontEndConfig& config);
  ~SlidingWindowTracker() override;

  TrackedScan track(const Scan& scan, const MotionPrior& prior) override;
  void restart() override;
  PointCloud local_map() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::front_end
