// SPDX-License-Identifier: BSD-3-Clause
#include "fix_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kMaxTripleDuration = 0.5;  // s for three fixes
constexpr std::size_t kMinCount = 25;       // bends
constexpr double kInitialSigma = 1.0;       // m; initial standard deviation
constexpr double kMaxSigmaRatio = 1.5;      // times the stated sigma
constexpr double kMedianOverRms = 0.83;     // of the length of a normally distributed plane vector

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
