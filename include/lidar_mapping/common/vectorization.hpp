// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What GCC and clang have under different names.

/// In front of a loop: no iteration reads what another one writes, so that the compiler may compute
/// several at once.
#ifdef __clang__
#define LIDAR_MAPPING_INDEPENDENT_ITERATIONS _Pragma("clang loop vectorize(assume_safety)")
#else
#define LIDAR_MAPPING_INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif

/// LIDAR_MAPPING_SHUFFLE(a, b, mask) and LIDAR_MAPPING_SHUFFLE(a, mask) choose values of vectors of
/// the compiler (its attribute vector_size): lane i of the result is value mask[i] of a or, counted
/// on behind the lanes of a, of b. The mask is a vector of integers as long as a. GCC has to see a
/// constant mask where it is used, hence a macro; clang lacks GCC's function.
#ifdef __clang__

namespace lidar_mapping {

template <typename Vector, typename Mask>
static inline __attribute__((always_inline)) Vector shuffled(const Vector& a, const Vector& b,
                                                             const Mask& mask) {
  constexpr int kLanes = sizeof(Mask) / sizeof(mask[0]);  // by definition
  Vector result = a;
  for (int lane = 0; lane < kLanes; ++lane) {
    const int from = mask[lane];
    result[lane] = from < kLanes ? a[from] : b[from - kLanes];
  }
  return result;
}

template <typename Vector, typename Mask>
static inline __attribute__((always_inline)) Vector shuffled(const Vector& a, const Mask& mask) {
  return shuffled(a, a, mask);
}

}  // namespace lidar_mapping

#define LIDAR_MAPPING_SHUFFLE lidar_mapping::shuffled
#else
#define LIDAR_MAPPING_SHUFFLE __builtin_shuffle
#endif
