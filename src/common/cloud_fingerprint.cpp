// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/cloud_fingerprint.hpp"

#include <array>
#include <cmath>
#include <cstring>

namespace lidar_mapping {
namespace {

// Chosen: no sensor measures even a few ranges twice alike.
constexpr std::size_t kSampledPoints = 256;
/// Least number of sampled points with a return. Chosen: a standing sensor whose ranges are in
/// millimetres measures one in ten of them alike.
constexpr int kMinSampledReturns = 20;
/// Coordinates are rounded to 0.1 mm. Chosen: drivers may round differently, far below the noise.
constexpr float kStepsPerMetre = 1e4F;

using Position = std::array<float, 3>;

void combine_hash(std::uint64_t value, std::uint64_t& hash) {
  // FNV-1a, a word at a time.
  hash = (hash ^ value) * 0x100000001b3ULL;
  hash ^= hash >> 29;
}

std::uint64_t rounded(float coordinate) {
  // Casting NaN or infinity to an integer is undefined behaviour.
  return std::isfinite(coordinate)
             ? static_cast<std::uint64_t>(std::llround(coordinate * kStepsPerMetre))
             : 1;
}

/// Drivers give a ray without a return no coordinates, or those of the sensor itself.
bool is_return(const Position& p) {
  const float sum = std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]);
  return std::isfinite(sum) && sum > 0.0F;
}

}  // namespace

std::optional<std::uint64_t> cloud_fingerprint(const unsigned char* first, std::size_t step,
                                               std::size_t count) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  combine_hash(count, hash);
  int returns = 0;
  // Odd, so that it visits all rings: one that sees only the sky has no points that could differ.
  const std::size_t stride = (count / kSampledPoints) | 1U;
  for (std::size_t i = 0; i < count; i += stride) {
    Position p;
    std::memcpy(p.data(), first + i * step, sizeof(p));
    for (const float coordinate : p) combine_hash(rounded(coordinate), hash);
    returns += is_return(p) ? 1 : 0;
  }
  if (returns < kMinSampledReturns) return std::nullopt;
  return hash;
}

std::optional<std::uint64_t> cloud_fingerprint(const PointCloud& cloud) {
  return cloud_fingerprint(reinterpret_cast<const unsigned char*>(cloud.points.data()),
                           sizeof(Point), cloud.size());
}

}  // namespace lidar_mapping
