// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/scan_numbers.hpp"

#include <algorithm>

namespace lidar_mapping::ros_border {

namespace {

/// Ten seconds of scans: connecting does not take longer, and few drivers have just been started
/// when a recording begins.
constexpr std::uint32_t kSmallNumber = 100;

}  // namespace

void ScanNumbers::take(std::uint32_t number) {
  if (!first_) {
    first_ = newest_ = number;
    received_ = 1;
    before_first_ = number <= kSmallNumber ? number : 0;
    return;
  }
  if (number <= newest_) {  // played again, another driver, or no numbers at all
    earlier_ = between();
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
  if (!first_ || step_ == 0) return earlier_;
  const std::size_t sent = (newest_ - *first_) / step_ + 1;
  return earlier_ + (sent > received_ ? sent - received_ : 0);
}

}  // namespace lidar_mapping::ros_border
