// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace lidar_mapping::simulation {

/// Mixes 64 bits (SplitMix64, Steele et al. 2014).
constexpr std::uint64_t mix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Generator of random numbers that are the same on every platform, unlike those of the standard
/// distributions. A generator is a value; one that is made from (seed, stream) does not depend on
/// any other stream. Draw at most one number among the arguments of a call or of an operator, where
/// the order is the compiler's choice; that of declarations and of braced lists is defined. Many
/// are drawn from the last argument to the first: so GCC drew them for the figures on record.
class Random {
 public:
  /// Different streams of a seed give independent numbers.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : state_(mix64(seed ^ mix64(stream))) {}

  /// The next 64 random bits.
  std::uint64_t bits() { return mix64(state_ += 0x9e3779b97f4a7c15ULL); }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform integer in [low, high].
  int integer(int low, int high) {
    return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
  }
  /// True with this probability.
  bool chance(double probability) { return uniform() < probability; }
  /// Standard normal distribution (Box and Muller 1958).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace lidar_mapping::simulation
