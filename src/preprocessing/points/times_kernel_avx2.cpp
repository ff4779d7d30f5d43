// SPDX-License-Identifier: BSD-3-Clause
// Compiled with AVX2 if the compiler supports it; only plain pointers are used in its interface.
#include "lidar_mapping/common/instruction_set.hpp"

#include "points/times_kernel.hpp"

#ifdef LIDAR_MAPPING_HAS_AVX2
#include <cstring>

#include <immintrin.h>
#endif

namespace lidar_mapping::preprocessing {

#ifdef LIDAR_MAPPING_HAS_AVX2

namespace {

// Floats in a register of 128 bits: a gather of 256 is slower, see below.
constexpr std::size_t kLanes = 4;

/// Uses single loads: a gather takes twice as long from the cache and five times as long from
/// memory, because it prevents the processor from prefetching.
__m128 four(const unsigned char* first, std::size_t step) {
  const auto at = [&](std::size_t k) {
    float value;
    std::memcpy(&value, first + k * step, sizeof(value));
    return _mm_set_ss(value);
  };
  const __m128 two = _mm_insert_ps(at(0), at(1), 0x10);
  return _mm_insert_ps(_mm_insert_ps(two, at(2), 0x20), at(3), 0x30);
}

/// Computes lane by lane; NaN changes nothing.
struct Extremes {
  __m128 least, greatest;

  void add(__m128 values) {
    least = _mm_min_ps(values, least);  // the second operand if the first is NaN
    greatest = _mm_max_ps(values, greatest);
  }
};

Bounds copy_floats(const SteppedFloats& from, float* to, Bounds bounds) {
  // Two independent chains hide the latency of a comparison.
  Extremes even{_mm_set1_ps(bounds.least), _mm_set1_ps(bounds.greatest)};
  Extremes odd = even;
  const unsigned char* in = from.first;
  const std::size_t whole = from.count - from.count % (2 * kLanes);
  for (std::size_t i = 0; i < whole; i += 2 * kLanes, in += 2 * kLanes * from.step) {
    const __m128 first = four(in, from.step);
    const __m128 second = four(in + kLanes * from.step, from.step);
    _mm_storeu_ps(to + i, first);
    _mm_storeu_ps(to + i + kLanes, second);
    even.add(first);
    odd.add(second);
  }
  float least[kLanes], greatest[kLanes];
  _mm_storeu_ps(least, _mm_min_ps(even.least, odd.least));
  _mm_storeu_ps(greatest, _mm_max_ps(even.greatest, odd.greatest));
  for (std::size_t k = 0; k < kLanes; ++k) {
    bounds.least = least[k] < bounds.least ? least[k] : bounds.least;
    bounds.greatest = greatest[k] > bounds.greatest ? greatest[k] : bounds.greatest;
  }
  return portable_times_kernel()({in, from.step, from.count - whole}, to + whole, bounds);
}

}  // namespace

TimesKernel avx2_times_kernel() {
  return processor_has(InstructionSet::kAvx2) ? copy_floats : nullptr;
}

#else

TimesKernel avx2_times_kernel() { return nullptr; }

#endif

}  // namespace lidar_mapping::preprocessing
