// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// First and last time of the points, s relative to the scan's stamp; both 0 without times.
struct TimeSpan {
  double begin = 0.0;
  double end = 0.0;
};
TimeSpan time_span(const PointCloud& cloud);

/// The span of times that come bit by bit; no finite one leaves both ends 0.
class TimeSpanFinder {
 public:
  void add(const float* times, std::size_t count);
  TimeSpan span() const;

 private:
  float first_ = std::numeric_limits<float>::max();
  float last_ = std::numeric_limits<float>::lowest();
};

/// Makes `count` times by blocks, which fill(begin, end) overwrites while they are in the nearest
/// cache: what a vector clears of new room costs little there.
template <typename Fill>
void fill_by_blocks(std::size_t count, std::vector<float>& times, const Fill& fill) {
  constexpr std::size_t kBlock = 2048;
  times.resize(std::min(times.size(), count));
  times.reserve(count);
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, count);
    if (times.size() < end) times.resize(end);
    fill(begin, end);
  }
}

/// Copies `count` floats, of which each begins `step` bytes after the one before, to `times`, and
/// returns their span.
TimeSpan read_times(const unsigned char* first, std::size_t step, std::size_t count,
                    std::vector<float>& times);

struct NormalizedTimes {
  TimeSpan span;        ///< of the times that there are now
  std::string problem;  ///< a sentence where something is wrong
};

/// Makes the times of a scan what the rest of the stage takes them for: seconds relative to the
/// stamp (`absolute` ones are that already), or none if the scan counts as compensated. An
/// implausible span leaves the scan without times. `known` is the span, where it is known already.
NormalizedTimes normalize_times(PointCloud& cloud, bool absolute, const PreprocessingConfig& config,
                                const std::optional<TimeSpan>& known = std::nullopt);

}  // namespace lidar_mapping::preprocessing
