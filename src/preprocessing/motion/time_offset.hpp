// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::preprocessing {

/// A value at an instant.
struct TimedValue {
  Stamp stamp = 0;
  double value = 0.0;
};

/// The delay of the stamps of `late` relative to those of `reference`, for the same signal (s),
/// with its standard deviation. Both signals must be in order of time.
struct TimeOffset {
  double seconds = 0.0;
  double sigma = 0.0;
};

/// Linear least squares: late(t + d) = reference(t), d = -sum(r f') / sum(f'^2) for the differences
/// r = late - reference and the slope f' of the reference. Empty if the signal hardly changes.
std::optional<TimeOffset> time_offset(const std::vector<TimedValue>& reference,
                                      const std::vector<TimedValue>& late);

}  // namespace lidar_mapping::preprocessing
