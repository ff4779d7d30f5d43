// The kernel of hash_kernel.hpp; included by one file per instruction set.

#include "hash_kernel.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kLanes = 8;
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
using Words = std::uint32_t __attribute__((vector_size(kLanes * sizeof(std::uint32_t))));

/// floor(u) times a factor, modulo 2^32.
inline __attribute__((always_inline)) void mix(const Floats& u, std::uint32_t factor,
                                               Words& words) {
  const Ints truncated = __builtin_convertvector(u, Ints);
  // A true comparison is -1 in all bits.
  const Ints cell = truncated + (__builtin_convertvector(truncated, Floats) > u);
  words ^= reinterpret_cast<const Words&>(cell) * factor;
}

inline __attribute__((always_inline)) void gather(const float* points, std::size_t step, Floats& x,
                                                  Floats& y, Floats& z) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const float* point = points + lane * step;
    x[lane] = point[0];
    y[lane] = point[1];
    z[lane] = point[2];
  }
}

inline __attribute__((always_inline)) void hash_lanes(const Floats& x, const Floats& y,
                                                      const Floats& z, const HashRule& rule,
                                                      Words& hashes) {
  const Floats range = x * x + y * y + z * z;
  // Written so that NaN fails.
  const Ints usable = (range >= rule.min_range_squared) & (range < rule.max_range_squared);
  const Floats zero = {};
  const float scale = rule.inverse_resolution;
  Words words = {};
  mix(usable ? x * scale : zero, 0x9E3779B1U, words);
  mix(usable ? y * scale : zero, 0x85EBCA77U, words);
  mix(usable ? z * scale : zero, 0xC2B2AE3DU, words);
  const Words refused = Words{} + rule.refused;
  hashes = usable ? (words * 0x27D4EB2FU) >> rule.shift : refused;
}

void hash_points(const float* points, std::size_t stride, std::size_t count, const HashRule& rule,
                 std::uint32_t* hashes) {
  const std::size_t step = 4 * stride;
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    Floats x{}, y{}, z{};
    Words words{};
    gather(points + i * step, step, x, y, z);
    hash_lanes(x, y, z, rule, words);
    for (std::size_t lane = 0; lane < kLanes; ++lane) hashes[i + lane] = words[lane];
  }
  for (; i < count; ++i) {
    const float* point = points + i * step;
    Words words{};
    hash_lanes(Floats{} + point[0], Floats{} + point[1], Floats{} + point[2], rule, words);
    hashes[i] = words[0];
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
