// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/line_limiter.hpp"

#include <utility>

namespace lidar_mapping::ros_border {

namespace {
constexpr double kInterval = 10.0;  // s; chosen: a person reads no more than this
}

std::optional<std::string> LineLimiter::add(std::string line, double now) {
  pending_ = std::move(line);
  if (printed_at_ && now - *printed_at_ < kInterval) return std::nullopt;
  printed_at_ = now;
  return rest();
}

std::optional<std::string> LineLimiter::rest() { return std::exchange(pending_, std::nullopt); }

}  // namespace lidar_mapping::ros_border
