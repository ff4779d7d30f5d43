// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::preprocessing {

/// A figure at an instant.
struct TimedValue {
  Stamp stamp = 0;
  double value = 0.0;
};

/// By how much the stamps of `late` are later than those of `reference` for the same course of a
/// figure (s), and how sure that is. Both in order of time.
struct TimeOffset {
  double seconds = 0.0;
  double sigma = 0.0;
};

/// Linear least squares: late(t + d) = reference(t), d = -sum(r f') / sum(f'^2) for the differences
/// r = late - reference and the slope f' of the reference. Nothing where the figure hardly changes.
std::optional<TimeOffset> time_offset(const std::vector<TimedValue>& reference,
                                      const std::vector<TimedValue>& late);

}  // namespace lidar_mapping::preprocessing
