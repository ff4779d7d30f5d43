// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace lidar_mapping::simulation {

/// Running mean over 2 `half_width` + 1 values, `passes` times; three passes come close to a
/// Gaussian. Beyond its ends the sequence goes on point-symmetrically, so that both ends stay.
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
