// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

#include "lidar_mapping/common/sorted_values.hpp"

namespace lidar_mapping::preprocessing {

/// Samples of one sensor in the order of their stamps, independent of the order of their arrival.
/// Time span and number are limited: the oldest samples are removed.
template <typename Sample>
class SampleBuffer {
 public:
  SampleBuffer(Stamp horizon, std::size_t capacity) : horizon_(horizon), capacity_(capacity) {}

  /// Inserts a sample. Returns false and changes nothing if its stamp is in the buffer already or
  /// older than the buffer's span.
  bool insert(Sample sample) {
    const auto at = first_not_before(samples_, sample.stamp);
    if (at != samples_.end() && at->stamp == sample.stamp) return false;
    if (at == samples_.begin() && !samples_.empty() && dropped_some_) return false;
    samples_.insert(at, std::move(sample));
    while (samples_.size() > capacity_ ||
           samples_.back().stamp - samples_.front().stamp > horizon_) {
      samples_.pop_front();
      dropped_some_ = true;
    }
    return true;
  }

  /// The neighbours of `stamp` (the same sample twice if it has exactly this stamp) if they are at
  /// most `max_gap` apart: the only pair between which values may be interpolated.
  std::optional<std::pair<const Sample*, const Sample*>> around(Stamp stamp, Stamp max_gap) const {
    const auto after = first_not_before(samples_, stamp);
    if (after == samples_.end()) return std::nullopt;
    if (after->stamp == stamp) return std::make_pair(&*after, &*after);
    if (after == samples_.begin()) return std::nullopt;
    const auto before = std::prev(after);
    if (after->stamp - before->stamp > max_gap) return std::nullopt;
    return std::make_pair(&*before, &*after);
  }

  /// The sample before the one with this stamp, if it is at most `max_gap` older; otherwise null.
  const Sample* before(Stamp stamp, Stamp max_gap) const {
    const auto at = first_not_before(samples_, stamp);
    if (at == samples_.begin()) return nullptr;
    const auto earlier = std::prev(at);
    return stamp - earlier->stamp <= max_gap ? &*earlier : nullptr;
  }

  /// The newest sample that is not after `stamp`; null if all are.
  const Sample* up_to(Stamp stamp) const {
    const auto after = std::upper_bound(samples_.begin(), samples_.end(), stamp, is_after);
    return after == samples_.begin() ? nullptr : &*std::prev(after);
  }

  /// Calls `visit` with each sample after `begin` that is not after `end`, in order.
  template <typename Visit>
  void for_each(Stamp begin, Stamp end, const Visit& visit) const {
    const auto first = std::upper_bound(samples_.begin(), samples_.end(), begin, is_after);
    const auto last = std::upper_bound(first, samples_.end(), end, is_after);
    std::for_each(first, last, visit);
  }

  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  const Sample& oldest() const { return samples_.front(); }
  const Sample& newest() const { return samples_.back(); }
  void clear() {
    samples_.clear();
    dropped_some_ = false;
  }

 private:
  static bool is_after(Stamp stamp, const Sample& sample) { return sample.stamp > stamp; }

  Stamp horizon_;
  std::size_t capacity_;
  std::deque<Sample> samples_;
  bool dropped_some_ = false;
};

}  // namespace lidar_mapping::preprocessing
