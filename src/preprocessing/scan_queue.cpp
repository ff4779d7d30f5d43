// SPDX-License-Identifier: BSD-3-Clause
#include "scan_queue.hpp"

#include <algorithm>
#include <utility>

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kMaxLength = 30;  // scans, 3 s at 10 Hz; chosen: 80 MB of 64 beams

}  // namespace

Insertion ScanQueue::insert(WaitingScan&& scan) {
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

bool ScanQueue::is_too_long() const { return scans_.size() > kMaxLength; }

WaitingScan ScanQueue::take_oldest() {
  WaitingScan scan = std::move(scans_.front());
  scans_.pop_front();
  last_released_ = scan.raw.stamp;
  return scan;
}

void ScanQueue::clear() {
  scans_.clear();
  last_released_.reset();
}

}  // namespace lidar_mapping::preprocessing
