// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping {

/// atan2(y, x) in rad, with an error of at most 2e-5 rad, by a polynomial. Without branches, so
/// that loops with it are vectorised, and always inlined, because files that are compiled for other
/// instruction sets use it too. x and y have the same unit; 0 if both are 0.
[[gnu::always_inline]] inline float fast_angle(float y, float x) {
  constexpr float kMinLength = 1e-37F;  // unit of x; chosen above zero, because it is a divisor
  const float along = __builtin_fabsf(x);
  const float across = __builtin_fabsf(y);
  const float larger = along > across ? along : across;
  const float longer = larger > kMinLength ? larger : kMinLength;
  const float a = (along < across ? along : across) / longer;
  const float s = a * a;
  const float low =
      a * (0.99997726F +
           s * (-0.33262347F +
                s * (0.19354346F + s * (-0.11643287F + s * (0.05265332F - s * 0.01172120F)))));
  const float high = 0.5F * kPiFloat - low;
  const float half = across > along ? high : low;
  const float other = kPiFloat - half;
  const float angle = x < 0.0F ? other : half;
  return y < 0.0F ? -angle : angle;
}

}  // namespace lidar_mapping
