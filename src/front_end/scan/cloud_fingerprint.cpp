// SPDX-License-Identifier: BSD-3-Clause
#include "scan/cloud_fingerprint.hpp"

#include <cmath>
#include <cstddef>

namespace lidar_mapping::front_end {
namespace {

// Chosen: no sensor measures even a few ranges twice alike.
constexpr std::size_t kSampledPoints = 256;
/// Chosen: clouds with fewer points may be equal by chance, or because they are empty.
constexpr std::size_t kMinPoints = 50;
/// Coordinates are rounded to 0.1 mm. Chosen: drivers may round differently, far below the noise.
constexpr float kStepsPerMetre = 1e4F;

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

}  // namespace

std::uint64_t cloud_fingerprint(const PointCloud& cloud) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  combine_hash(cloud.size(), hash);
  // Odd, so that it visits all rings: one that sees only the sky has no points that could differ.
  const std::size_t step = (cloud.size() / kSampledPoints) | 1U;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Point& point = cloud.points[i];
    for (const float coordinate : {point.x, point.y, point.z})
      combine_hash(rounded(coordinate), hash);
  }
  return hash;
}

bool RepeatedScans::is_repeated(const PointCloud& cloud) {
  if (cloud.size() < kMinPoints) {
    reset();
    return false;
  }
  const std::uint64_t fingerprint = cloud_fingerprint(cloud);
  const bool same = last_ == fingerprint;
  last_ = fingerprint;
  return same;
}

}  // namespace lidar_mapping::front_end
