// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"

#include "judgement/covariance_inflation.hpp"
#include "key_frame_rule.hpp"
#include "scan/scan_sampler.hpp"
#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Decides which scans become key frames, and makes them.
class KeyFrameMaker {
 public:
  explicit KeyFrameMaker(const FrontEndConfig& config);

  /// To be called for each step between scans, in their order.
  void add_step(const TrackedScan& from, const TrackedScan& to);
  /// The steps since the last key frame will be added again.
  void reset_steps() { inflation_ = {}; }
  /// The next key frame is not connected with the last one.
  void start_segment();
  /// The same, and the next key frame has this index.
  void resume(KeyFrameIndex next_index);

  /// True if the scan is far enough from the last key frame, and reliable. `has_times`: its points
  /// have times, so that they can only be deskewed if the motion is known.
  bool is_due(Stamp stamp, bool has_times, const TrackedScan& tracked) const;
  /// The scan's points for a key frame before deskewing: thinned out, and rotated upwards by
  /// PointCorrection::elevation_shift.
  PointCloud points_of(const PointCloud& cloud, const TrackedScan& tracked);
  /// `points` is the result of points_of(); `tracker` knows the covariance of the motion.
  KeyFrame make(Stamp stamp, std::uint32_t segment, const TrackedScan& tracked, PointCloud points,
                const Tracker& tracker);

 private:
  PointCloud thinned(const PointCloud& cloud);

  double resolution_;  ///< of the key frames' clouds, m
  int threads_;
  ScanSampler sampler_{19};
  KeyFrameRule rule_;
  KeyFrameRule degraded_rule_;
  std::optional<TrackedScan> last_;
  Stamp last_stamp_ = 0;
  CovarianceInflation inflation_;  ///< of the motion since then
  KeyFrameIndex next_index_ = 0;
};

}  // namespace lidar_mapping::front_end
