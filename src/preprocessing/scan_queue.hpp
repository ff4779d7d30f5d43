// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "motion/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

struct WaitingScan {
  RawScan raw;
  TimeSpan span;
};

/// Scans that wait for the other sensors, in the order of their stamps.
class ScanQueue {
 public:
  /// Rejects a scan whose stamp is in the queue already, or not after all scans that were released.
  /// If time has gone back so far that the recording must have started again, nothing is inserted,
  /// and the result is kTimeWentBack.
  Insertion insert(WaitingScan&& scan) {
    const Stamp stamp = scan.raw.stamp;
    const Stamp newest = scans_.empty() ? last_released_.value_or(stamp) : scans_.back().raw.stamp;
    if (stamp < newest - kJumpBack) return Insertion::kTimeWentBack;
    const auto is_before = [](const WaitingScan& a, Stamp b) { return a.raw.stamp < b; };
    const auto at = std::lower_bound(scans_.begin(), scans_.end(), stamp, is_before);
    const bool is_duplicate = at != scans_.end() && at->raw.stamp == stamp;
    if (is_duplicate || (last_released_ && stamp <= *last_released_)) return Insertion::kRefused;
    scans_.insert(at, std::move(scan));
    return Insertion::kInserted;
  }

  bool empty() const { return scans_.empty(); }
  std::size_t size() const { return scans_.size(); }
  /// True if the queue is too long: the oldest scan has to be released.
  bool is_too_long() const { return scans_.size() > kMaxLength; }
  const WaitingScan& oldest() const { return scans_.front(); }
  WaitingScan take_oldest() {
    WaitingScan scan = std::move(scans_.front());
    scans_.pop_front();
    last_released_ = scan.raw.stamp;
    return scan;
  }
  void clear() { *this = {}; }

 private:
  // Scans, 3 s at 10 Hz; chosen: 80 MB of 64 beams.
  static constexpr std::size_t kMaxLength = 30;

  std::deque<WaitingScan> scans_;
  std::optional<Stamp> last_released_;
};

}  // namespace lidar_mapping::preprocessing
