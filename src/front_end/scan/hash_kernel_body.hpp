// SPDX-License-Identifier: BSD-3-Clause
// The kernel of hash_kernel.hpp; included by one file per instruction set.

#include <cstring>

#include "lidar_mapping/common/vectorization.hpp"

#include "scan/hash_kernel.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kLanes = 8;  // floats in a register of 256 bits, AVX2
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
using Words = std::uint32_t __attribute__((vector_size(kLanes * sizeof(std::uint32_t))));

/// floor(u) times a factor, modulo 2^32.
inline __attribute__((always_inline)) void combine_hash(const Floats& u, std::uint32_t factor,
                                                        Words& words) {
  const Ints truncated = __builtin_convertvector(u, Ints);
  // A true comparison is -1 in all bits.
  const Ints cell = truncated + (__builtin_convertvector(truncated, Floats) > u);
  words ^= reinterpret_cast<const Words&>(cell) * factor;
}

inline __attribute__((always_inline)) void gather(const float* points, std::size_t step, Floats& x,
                                                  Floats& y, Floats& z) {
  const float* point = points;
  for (std::size_t lane = 0; lane < kLanes; ++lane, point += step) {
    x[lane] = point[0];
    y[lane] = point[1];
    z[lane] = point[2];
  }
}

/// Coordinates of eight points of four floats that lie side by side, in the order 0 2 4 6 1 3 5 7.
inline __attribute__((always_inline)) void load_neighbors(const float* points, Floats& x, Floats& y,
                                                          Floats& z) {
  // Written as single variables: an array of vectors would be copied through the stack.
  Floats p01, p23, p45, p67;
  std::memcpy(&p01, points, sizeof(p01));
  std::memcpy(&p23, points + 8, sizeof(p23));
  std::memcpy(&p45, points + 16, sizeof(p45));
  std::memcpy(&p67, points + 24, sizeof(p67));
  constexpr Ints kLower = {0, 8, 1, 9, 4, 12, 5, 13};
  constexpr Ints kUpper = {2, 10, 3, 11, 6, 14, 7, 15};
  constexpr Ints kFirst = {0, 1, 8, 9, 4, 5, 12, 13};
  constexpr Ints kSecond = {2, 3, 10, 11, 6, 7, 14, 15};
  const Floats xy0 = LIDAR_MAPPING_SHUFFLE(p01, p23, kLower);
  const Floats xy1 = LIDAR_MAPPING_SHUFFLE(p45, p67, kLower);
  const Floats zw0 = LIDAR_MAPPING_SHUFFLE(p01, p23, kUpper);
  const Floats zw1 = LIDAR_MAPPING_SHUFFLE(p45, p67, kUpper);
  x = LIDAR_MAPPING_SHUFFLE(xy0, xy1, kFirst);
  y = LIDAR_MAPPING_SHUFFLE(xy0, xy1, kSecond);
  z = LIDAR_MAPPING_SHUFFLE(zw0, zw1, kFirst);
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
  combine_hash(usable ? x * scale : zero, 0x9E3779B1U, words);
  combine_hash(usable ? y * scale : zero, 0x85EBCA77U, words);
  combine_hash(usable ? z * scale : zero, 0xC2B2AE3DU, words);
  const Words rejected = Words{} + rule.rejected;
  hashes = usable ? (words * 0x27D4EB2FU) >> rule.shift : rejected;
}

void hash_points(const float* points, std::size_t stride, std::size_t count, const HashRule& rule,
                 std::uint32_t* hashes) {
  const std::size_t step = 4 * stride;
  std::size_t i = 0;
  for (; stride == 1 && i + kLanes <= count; i += kLanes) {
    constexpr Ints kInOrder = {0, 4, 1, 5, 2, 6, 3, 7};
    Floats x, y, z;
    Words words{};
    load_neighbors(points + i * step, x, y, z);
    hash_lanes(x, y, z, rule, words);
    words = LIDAR_MAPPING_SHUFFLE(words, kInOrder);
    std::memcpy(hashes + i, &words, sizeof(words));
  }
  for (; i + kLanes <= count; i += kLanes) {
    Floats x{}, y{}, z{};
    Words words{};
    gather(points + i * step, step, x, y, z);
    hash_lanes(x, y, z, rule, words);
    std::memcpy(hashes + i, &words, sizeof(words));
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
