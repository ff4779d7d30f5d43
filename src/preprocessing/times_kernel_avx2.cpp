// Compiled with AVX2 where the compiler has it; nothing but plain pointers crosses its border.
#include "times_kernel.hpp"

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace lidar_mapping::preprocessing {

#ifdef __AVX2__

namespace {

constexpr std::size_t kLanes = 8;

Bounds copy_floats(const SteppedFloats& from, float* to, Bounds bounds) {
  const __m256i number = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i steps = _mm256_mullo_epi32(number, _mm256_set1_epi32(static_cast<int>(from.step)));
  __m256 least = _mm256_set1_ps(bounds.least);
  __m256 greatest = _mm256_set1_ps(bounds.greatest);
  const std::size_t whole = from.count - from.count % kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    const void* in = from.first + i * from.step;
    const __m256 values = _mm256_i32gather_ps(static_cast<const float*>(in), steps, 1);
    _mm256_storeu_ps(to + i, values);
    least = _mm256_min_ps(values, least);  // the second one where the first is NaN
    greatest = _mm256_max_ps(values, greatest);
  }
  alignas(32) float lanes[2 * kLanes];
  _mm256_store_ps(lanes, least);
  _mm256_store_ps(lanes + kLanes, greatest);
  for (std::size_t k = 0; k < kLanes; ++k) {
    bounds.least = lanes[k] < bounds.least ? lanes[k] : bounds.least;
    bounds.greatest = lanes[k + kLanes] > bounds.greatest ? lanes[k + kLanes] : bounds.greatest;
  }
  const SteppedFloats rest{from.first + whole * from.step, from.step, from.count - whole};
  return portable_times_kernel()(rest, to + whole, bounds);
}

}  // namespace

TimesKernel avx2_times_kernel() { return __builtin_cpu_supports("avx2") ? copy_floats : nullptr; }

#else

TimesKernel avx2_times_kernel() { return nullptr; }

#endif

}  // namespace lidar_mapping::preprocessing
