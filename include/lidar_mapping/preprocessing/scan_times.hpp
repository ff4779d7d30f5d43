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

/// First and last time of the points, s relative to the scan's stamp; both are 0 without times.
struct TimeSpan {
  double begin = 0.0;  ///< s
  double end = 0.0;    ///< s
};
/// First and last time of a cloud; times that are not a number (NaN) do not count. An infinite time
/// does, and makes the span implausible.
TimeSpan time_span(const PointCloud& cloud);

/// Finds the span of times that are added in parts; both ends are 0 if all are NaN.
class TimeSpanFinder {
 public:
  /// Adds `count` times, s.
  void add(const float* times, std::size_t count);
  /// The span of all that were added.
  TimeSpan span() const;

 private:
  float first_ = std::numeric_limits<float>::max();
  float last_ = std::numeric_limits<float>::lowest();
};

/// Makes `count` times by blocks. fill(begin, end) overwrites a block while it is in the nearest
/// cache, so that the zeros written by the vector's resize() cost little.
template <typename Fill>
void fill_by_blocks(std::size_t count, std::vector<float>& times, const Fill& fill) {
  // Times, 8 kB. Chosen: a quarter of a first-level cache of 32 kB.
  constexpr std::size_t kBlock = 2048;
  times.resize(std::min(times.size(), count));
  times.reserve(count);
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, count);
    if (times.size() < end) times.resize(end);
    fill(begin, end);
  }
}

/// Copies `count` floats, which are `step` bytes apart, to `times`, and returns their span.
TimeSpan read_times(const unsigned char* first, std::size_t step, std::size_t count,
                    std::vector<float>& times);

/// What normalize_times() has found.
struct NormalizedTimes {
  TimeSpan span;        ///< span of the resulting times, s relative to the stamp
  std::string problem;  ///< a message if something is wrong, otherwise empty
};

/// Converts the times of a scan to seconds relative to the stamp (`absolute` times are that
/// already), or removes them if the scan is taken as motion-compensated. If the span is
/// implausible, the scan gets no times. `known` is the span, if it is known already.
NormalizedTimes normalize_times(PointCloud& cloud, bool absolute, const PreprocessingConfig& config,
                                const std::optional<TimeSpan>& known = std::nullopt);

}  // namespace lidar_mapping::preprocessing
