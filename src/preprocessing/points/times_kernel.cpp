// SPDX-License-Identifier: BSD-3-Clause
#include "points/times_kernel.hpp"

#include <cstring>

namespace lidar_mapping::preprocessing {

namespace {

Bounds copy_floats(const SteppedFloats& from, float* to, Bounds bounds) {
  const unsigned char* in = from.first;
  for (std::size_t i = 0; i < from.count; ++i, in += from.step) {
    float value;
    std::memcpy(&value, in, sizeof(value));
    to[i] = value;
    bounds.least = value < bounds.least ? value : bounds.least;  // false for NaN
    bounds.greatest = value > bounds.greatest ? value : bounds.greatest;
  }
  return bounds;
}

}  // namespace

TimesKernel portable_times_kernel() { return copy_floats; }

TimesKernel times_kernel() {
  static const TimesKernel chosen =
      avx2_times_kernel() != nullptr ? avx2_times_kernel() : portable_times_kernel();
  return chosen;
}

}  // namespace lidar_mapping::preprocessing
