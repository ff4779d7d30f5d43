// SPDX-License-Identifier: BSD-3-Clause
#include "scan_queue.hpp"

#include <algorithm>
#include <utility>

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kLongest = 30;            // scans
constexpr Stamp kJumpBack = from_seconds(2.0);  // the recording has begun anew

}  // namespace

Insertion ScanQueue::insert(WaitingScan&& scan) {
  const Stamp stamp = scan.raw.stamp;
  const Stamp newest = waiting_.empty() ? last_out_.value_or(stamp) : waiting_.back().raw.stamp;
  if (stamp < newest - kJumpBack) return Insertion::kTimeWentBack;
  const auto is_before = [](const WaitingScan& a, Stamp b) { return a.raw.stamp < b; };
  const auto at = std::lower_bound(waiting_.begin(), waiting_.end(), stamp, is_before);
  const bool is_there = at != waiting_.end() && at->raw.stamp == stamp;
  if (is_there || (last_out_ && stamp <= *last_out_)) return Insertion::kRefused;
  waiting_.insert(at, std::move(scan));
  return Insertion::kTaken;
}

bool ScanQueue::is_too_long() const { return waiting_.size() > kLongest; }

WaitingScan ScanQueue::take_oldest() {
  WaitingScan scan = std::move(waiting_.front());
  waiting_.pop_front();
  last_out_ = scan.raw.stamp;
  return scan;
}

void ScanQueue::clear() {
  waiting_.clear();
  last_out_.reset();
}

}  // namespace lidar_mapping::preprocessing
