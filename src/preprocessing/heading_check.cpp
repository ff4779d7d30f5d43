// SPDX-License-Identifier: BSD-3-Clause
#include "heading_check.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kStretch = 5.0;          // m
constexpr double kSigmasOfStretch = 8.0;  // course good to about 10 degrees
constexpr double kStraight = 0.35;        // rad of turning within a stretch
constexpr double kAgreement = 15.0 * kRadPerDeg;
constexpr double kContradiction = 30.0 * kRadPerDeg;
constexpr int kEnough = 3;

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

}  // namespace

void HeadingCheck::add(const Eigen::Vector3d& p_enu, double sigma,
                       const Eigen::Quaterniond& R_enu_base, bool backwards) {
  const double yaw = yaw_of(R_enu_base) + (backwards ? kPi : 0.0);
  if (!from_ || std::abs(wrapped(yaw - yaw_from_)) > kStraight) {
    from_ = p_enu;
    yaw_from_ = yaw;
    return;
  }
  const Eigen::Vector3d step = p_enu - *from_;
  if (step.head<2>().norm() < std::max(kStretch, kSigmasOfStretch * sigma)) return;
  judge(step, yaw_from_ + 0.5 * wrapped(yaw - yaw_from_));
  from_ = p_enu;
  yaw_from_ = yaw;
}

void HeadingCheck::judge(const Eigen::Vector3d& step, double yaw) {
  last_difference_ = wrapped(std::atan2(step.y(), step.x()) - yaw);
  const double size = std::abs(last_difference_);
  agreements_ = size < kAgreement ? agreements_ + 1 : 0;
  contradictions_ = size > kContradiction ? contradictions_ + 1 : 0;
  if (agreements_ >= kEnough) verdict_ = true;
  if (contradictions_ >= kEnough) verdict_ = false;
}

}  // namespace lidar_mapping::preprocessing
