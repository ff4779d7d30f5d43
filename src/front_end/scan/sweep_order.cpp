// SPDX-License-Identifier: BSD-3-Clause
#include "scan/sweep_order.hpp"

#include <cmath>

namespace lidar_mapping::front_end {
namespace {

/// Number of points that are used, evenly spaced. Chosen as a prime number: if it had a common
/// divisor with the number of rings, points of different rings would lie in the same direction.
constexpr std::size_t kProbes = 47;
/// rad. Between two of these points a full turn advances by 0.13 rad; chosen: thrice as much, for
/// missing points.
constexpr double kMaxAdvance = 0.4;
/// Fraction of the points that have to advance so little. Chosen: a few may be beside wide gaps,
/// and in another order one in eight advances so little by chance (0.8 / 2 pi).
constexpr double kMinFraction = 0.8;

}  // namespace

bool in_sweep_order(const PointCloud& cloud) {
  if (cloud.size() < kProbes) return false;
  const std::size_t step = cloud.size() / kProbes;
  std::size_t advancing = 0;
  for (std::size_t i = 1; i < kProbes; ++i) {
    const Point& from = cloud.points[(i - 1) * step];
    const Point& to = cloud.points[i * step];
    const double advance = std::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y);
    // Written so that NaN fails.
    if (std::abs(advance) < kMaxAdvance) ++advancing;
  }
  return static_cast<double>(advancing) >= kMinFraction * static_cast<double>(kProbes - 1);
}

}  // namespace lidar_mapping::front_end
