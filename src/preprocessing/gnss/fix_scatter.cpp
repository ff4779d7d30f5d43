// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/fix_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// s for three fixes, a rate of 4 Hz. Chosen: in 0.25 s an acceleration of 1 m/s^2 bends the path by
// 6 cm; at lower rates the motion of the vehicle would count as noise.
constexpr double kMaxTripleDuration = 0.5;
// Second differences for a median. Chosen: 2.5 s at 10 Hz; the median of 25 independent values is
// good to 15 %.
constexpr std::size_t kMinCount = 25;
// m, standard deviation until that many are known. Chosen as of a receiver without corrections.
constexpr double kInitialSigma = 1.0;
// Multiple of the stated standard deviation. Chosen above the scatter of the estimate itself.
constexpr double kMaxSigmaRatio = 1.5;
// Ratio of median and root mean square of the length of a normally distributed vector in the plane
// (Rayleigh distribution): sqrt(ln 2).
constexpr double kMedianOverRms = 0.83;

double median_of(const std::deque<double>& values) {
  return median(std::vector<double>(values.begin(), values.end()));
}

}  // namespace

void FixScatter::add(const LocalFix& fix) {
  last_fixes_.push_back(fix);
  if (last_fixes_.size() < 3) return;
  if (last_fixes_.size() > 3) last_fixes_.pop_front();
  if (to_seconds(last_fixes_[2].stamp - last_fixes_[0].stamp) > kMaxTripleDuration) return;
  const Eigen::Vector3d second_difference =
      last_fixes_[2].p_enu - 2.0 * last_fixes_[1].p_enu + last_fixes_[0].p_enu;
  second_differences_.push_back(second_difference.head<2>().norm() / std::sqrt(6.0));
  sigmas_.push_back(std::sqrt(fix.covariance.topLeftCorner<2, 2>().trace()));
  if (second_differences_.size() <= kMaxCount) return;
  second_differences_.pop_front();
  sigmas_.pop_front();
}

bool FixScatter::is_known() const { return second_differences_.size() >= kMinCount; }
double FixScatter::measured() const { return median_of(second_differences_) / kMedianOverRms; }
double FixScatter::stated() const { return median_of(sigmas_); }

double FixScatter::variance_factor() const {
  if (second_differences_.empty()) return 1.0;
  if (!is_known()) return std::max(1.0, std::pow(kInitialSigma / stated(), 2));
  const double ratio = measured() / stated();
  return ratio > kMaxSigmaRatio ? ratio * ratio : 1.0;
}

}  // namespace lidar_mapping::preprocessing
