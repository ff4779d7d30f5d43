// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/ouster_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Latest time of a sensor, ns; as in ouster_packets.cpp, so that sums of times do not overflow.
constexpr Stamp kLastTime = Stamp{1} << 62U;
/// Largest offset of clocks that are the same, s. Chosen: packets wait in a network for less.
constexpr double kSameClock = 0.05;
/// How far atomic time, which PTP has, is ahead of UTC, s, by definition of UTC since 2017.
constexpr double kAtomicTime = 37.0;

bool is_time(Stamp sensor) { return sensor >= 0 && sensor <= kLastTime; }

}  // namespace

Stamp OusterClock::to_ros(Stamp sensor) const {
  if (!is_time(sensor)) throw InputError("a time of the sensor is out of range");
  const double passed = static_cast<double>(sensor - begin);
  return sensor + offset + static_cast<Stamp>(std::llround(drift * passed));
}

std::optional<Stamp> known_offset(Stamp offset) {
  for (const double known : {0.0, -kAtomicTime}) {
    if (std::abs(to_seconds(offset) - known) < kSameClock) return from_seconds(known);
  }
  return std::nullopt;
}

/// Only the newest parts count, so that a drift, a sensor that was switched on anew and a clock of
/// ROS that was set are followed.
void OusterClockTracker::add(Stamp sensor, Stamp received) {
  if (!is_time(sensor) || received <= 0) return;
  const Stamp part = from_seconds(kOusterClockPart);
  // A time that is far from the one before is damaged, or a new clock begins with it.
  const bool is_near = std::abs(sensor - newest_.value_or(sensor)) <= part;
  newest_ = sensor;
  if (!is_near) return;
  const Stamp passed = received - begin_;
  if (passed > part || passed < -part) {
    const bool is_next = passed > 0 && passed <= 2 * part;
    before_ = is_next ? present_ : std::nullopt;
    present_.reset();
    begin_ = received;
  }
  const Stamp offset = received - sensor;
  present_ = std::min(offset, present_.value_or(offset));
}

OusterClock OusterClockTracker::clock() const {
  if (!present_) return {};
  const Stamp soonest = std::min(*present_, before_.value_or(*present_));
  return {0, known_offset(soonest).value_or(soonest), 0.0};
}

}  // namespace lidar_mapping::ros_border
