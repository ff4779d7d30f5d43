// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace lidar_mapping::simulation {

/// From 0 at u = 0 (and below) to 1 at u = 1 (and above), with two continuous derivatives.
inline double smooth_step(double u) {
  const double v = std::clamp(u, 0.0, 1.0);
  return v * v * v * (10.0 + v * (6.0 * v - 15.0));
}

/// Moving average over 2 `half_width` + 1 values, repeated `passes` times; three passes are close
/// to a Gaussian filter. The sequence is extended point-symmetrically beyond its ends, so that both
/// end values are kept.
template <typename T>
std::vector<T> smoothed(std::vector<T> values, int half_width, int passes) {
  const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<T> before = values;
    const auto at = [&](std::ptrdiff_t i) -> T {
      if (i < 0) return 2.0 * before[0] - before[-i > last ? last : -i];
      if (i > last) return 2.0 * before[last] - before[2 * last - i < 0 ? 0 : 2 * last - i];
      return before[i];
    };
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
      T sum = at(i);
      for (int k = 1; k <= half_width; ++k) sum += at(i - k) + at(i + k);
      values[i] = sum / (2.0 * half_width + 1.0);
    }
  }
  return values;
}

}  // namespace lidar_mapping::simulation
