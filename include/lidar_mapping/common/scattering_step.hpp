// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <numeric>

namespace lidar_mapping {

/// A step near the golden section of a number of things. If they are visited with this step, modulo
/// their number, successive ones are far apart. None is left out, because the step has no common
/// divisor with the number.
inline std::size_t scattering_step(std::size_t count) {
  std::size_t step = count * 618 / 1000 + 1;
  while (std::gcd(step, count) > 1) ++step;
  return step;
}

}  // namespace lidar_mapping
