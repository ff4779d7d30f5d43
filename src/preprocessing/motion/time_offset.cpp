// SPDX-License-Identifier: BSD-3-Clause
#include "motion/time_offset.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/sorted_values.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// s between values of the reference. Chosen: traffic changes its course little in a quarter second.
constexpr double kMaxGap = 0.25;
// s over which a slope is computed, to reduce noise. Chosen: below the duration of a turn.
constexpr double kSlopeInterval = 0.2;
constexpr std::size_t kMinValues = 100;  // a second at 100 Hz; chosen: fewer may hold no turn

std::optional<double> value_at(const std::vector<TimedValue>& values, Stamp stamp) {
  const auto after = first_not_before(values, stamp);
  if (after == values.begin() || after == values.end()) return std::nullopt;
  const auto before = std::prev(after);
  const double gap = to_seconds(after->stamp - before->stamp);
  if (gap > kMaxGap || gap <= 0.0) return std::nullopt;
  const double fraction = to_seconds(stamp - before->stamp) / gap;
  return before->value + fraction * (after->value - before->value);
}

}  // namespace

std::optional<TimeOffset> time_offset(const std::vector<TimedValue>& reference,
                                      const std::vector<TimedValue>& late) {
  double slopes = 0.0, products = 0.0, squares = 0.0;
  std::size_t count = 0;
  const Stamp half = from_seconds(0.5 * kSlopeInterval);
  for (const TimedValue& sample : late) {
    const auto here = value_at(reference, sample.stamp);
    const auto before = value_at(reference, sample.stamp - half);
    const auto after = value_at(reference, sample.stamp + half);
    if (!here || !before || !after) continue;
    const double slope = (*after - *before) / kSlopeInterval;
    const double difference = sample.value - *here;
    slopes += slope * slope;
    products += difference * slope;
    squares += difference * difference;
    ++count;
  }
  if (count < kMinValues || slopes <= 0.0) return std::nullopt;
  const double seconds = -products / slopes;
  const double rest = std::max(0.0, squares - products * products / slopes);
  return TimeOffset{seconds, std::sqrt(rest / static_cast<double>(count) / slopes)};
}

}  // namespace lidar_mapping::preprocessing
