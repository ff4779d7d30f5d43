// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidar_mapping::preprocessing {

/// Floats at equal steps in memory.
struct SteppedFloats {
  const unsigned char* first;
  std::size_t step;  ///< bytes from one to the next
  std::size_t count;
};

struct Bounds {
  float least;
  float greatest;
};

/// Copies the floats to `to`, one after the other, and widens the bounds to hold those that are
/// numbers.
using TimesKernel = Bounds (*)(const SteppedFloats& from, float* to, Bounds bounds);

/// The fastest one that this processor can run; all give the same.
TimesKernel times_kernel();
TimesKernel portable_times_kernel();
/// Null where the compiler or the processor knows no AVX2.
TimesKernel avx2_times_kernel();

}  // namespace lidar_mapping::preprocessing
