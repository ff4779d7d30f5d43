// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/scan_numbers.hpp"

#include <algorithm>

namespace lidar_mapping::ros_border {

namespace {

/// Largest number of a first scan at which the scans before it count as missing: ten seconds of
/// scans. Chosen: connecting does not take longer, and few drivers have just been started when a
/// recording begins.
constexpr std::uint32_t kSmallNumber = 100;

}  // namespace

void ScanNumbers::add(std::uint32_t number) {
  if (!first_) {
    first_ = newest_ = number;
    received_ = 1;
    before_first_ = number <= kSmallNumber ? number : 0;
    return;
  }
  if (number <= newest_) {  // replayed, another driver, or no numbers at all
    missing_before_restart_ = between();
    first_ = newest_ = number;
    received_ = 1;
    step_ = 0;
    return;
  }
  const std::uint32_t step = number - newest_;
  step_ = step_ == 0 ? step : std::min(step_, step);
  newest_ = number;
  ++received_;
}

std::size_t ScanNumbers::between() const {
  if (!first_ || step_ == 0) return missing_before_restart_;
  const std::size_t sent = (newest_ - *first_) / step_ + 1;
  return missing_before_restart_ + (sent > received_ ? sent - received_ : 0);
}

}  // namespace lidar_mapping::ros_border
