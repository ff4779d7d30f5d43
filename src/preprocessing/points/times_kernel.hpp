// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidar_mapping::preprocessing {

/// Floats at equal distances in memory.
struct SteppedFloats {
  const unsigned char* first;
  std::size_t step;  ///< bytes from one to the next
  std::size_t count;
};

struct Bounds {
  float least;
  float greatest;
};

/// Copies the floats to `to` without gaps, and extends the bounds to include those that are not
/// NaN.
using TimesKernel = Bounds (*)(const SteppedFloats& from, float* to, Bounds bounds);

/// The fastest kernel that this processor can run; all kernels give the same result.
TimesKernel times_kernel();
TimesKernel portable_times_kernel();
/// Null if the compiler or the processor does not support AVX2.
TimesKernel avx2_times_kernel();

}  // namespace lidar_mapping::preprocessing
