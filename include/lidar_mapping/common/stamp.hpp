// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace lidar_mapping {

/// An instant in nanoseconds since the epoch. Integers, so that a stamp survives every copy bit for
/// bit; differences become seconds only where physics needs them.
using Stamp = std::int64_t;
/// Stamps in a second, by definition.
constexpr Stamp kNanosecondsPerSecond = 1'000'000'000;

/// Length of an interval in seconds.
constexpr double to_seconds(Stamp interval) { return static_cast<double>(interval) * 1e-9; }

/// The interval of `seconds`, rounded to the nearest nanosecond.
constexpr Stamp from_seconds(double seconds) {
  return static_cast<Stamp>(seconds * 1e9 + (seconds < 0.0 ? -0.5 : 0.5));
}

}  // namespace lidar_mapping
