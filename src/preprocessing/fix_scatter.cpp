// SPDX-License-Identifier: BSD-3-Clause
#include "fix_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kLongestPair = 0.5;     // s for three fixes
constexpr std::size_t kFewest = 25;      // bends
constexpr double kUnproven = 1.0;        // m; standard deviation to begin with
constexpr double kTooConfident = 1.5;    // times the stated sigma
constexpr double kMedianOverRms = 0.83;  // of the length of a normally distributed plane vector

double median_of(const std::deque<double>& values) {
  return median(std::vector<double>(values.begin(), values.end()));
}

}  // namespace

void FixScatter::add(const LocalFix& fix) {
  last_.push_back(fix);
  if (last_.size() < 3) return;
  if (last_.size() > 3) last_.pop_front();
  if (to_seconds(last_[2].stamp - last_[0].stamp) > kLongestPair) return;
  const Eigen::Vector3d bend = last_[2].p_enu - 2.0 * last_[1].p_enu + last_[0].p_enu;
  bends_.push_back(bend.head<2>().norm() / std::sqrt(6.0));
  sigmas_.push_back(std::sqrt(fix.covariance.topLeftCorner<2, 2>().trace()));
  if (bends_.size() <= kRemembered) return;
  bends_.pop_front();
  sigmas_.pop_front();
}

bool FixScatter::is_known() const { return bends_.size() >= kFewest; }
double FixScatter::measured() const { return median_of(bends_) / kMedianOverRms; }
double FixScatter::stated() const { return median_of(sigmas_); }

double FixScatter::variance_factor() const {
  if (bends_.empty()) return 1.0;
  if (!is_known()) return std::max(1.0, std::pow(kUnproven / stated(), 2));
  const double ratio = measured() / stated();
  return ratio > kTooConfident ? ratio * ratio : 1.0;
}

}  // namespace lidar_mapping::preprocessing
