// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// Matches scans against a window of the last key frames with any registration method. When a new
/// key frame enters the window, all key frames are joined and thinned out to one target. Scans are
/// thinned out and aligned, starting from a prediction with constant velocity. This is the scheme
/// of the articles (doc/front_end.md). It is intended for comparing methods, because the target is
/// built anew each time.
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
