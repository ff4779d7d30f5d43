// SPDX-License-Identifier: BSD-3-Clause
#include "checks/heading_check.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// Length of a section, m and in standard deviations of a position. Chosen: shorter ones are within
// the swaying of an antenna, and with the latter the course is good to about 10 degrees (sqrt(2) /
// 8 rad).
constexpr double kMinSectionLength = 5.0;
constexpr double kMinSigmasOfSection = 8.0;
// rad (20 degrees) of turning within a section. Chosen: the chord then has the direction of its
// middle to less than a degree.
constexpr double kMaxTurning = 0.35;
// Chosen above the error of a course, which is about 10 degrees.
constexpr double kAgreement = 15.0 * kRadPerDeg;
// Chosen: between both nothing is decided.
constexpr double kContradiction = 30.0 * kRadPerDeg;
constexpr int kMinCount = 3;  // sections in a row; chosen: more decide later

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

}  // namespace

void HeadingCheck::add(const Eigen::Vector3d& p_enu, double sigma,
                       const Eigen::Quaterniond& R_enu_base, bool backwards) {
  const double yaw = yaw_of(R_enu_base) + (backwards ? kPi : 0.0);
  if (!section_start_ || std::abs(wrapped(yaw - section_start_yaw_)) > kMaxTurning) {
    section_start_ = p_enu;
    section_start_yaw_ = yaw;
    return;
  }
  const Eigen::Vector3d step = p_enu - *section_start_;
  if (step.head<2>().norm() < std::max(kMinSectionLength, kMinSigmasOfSection * sigma)) return;
  update(step, section_start_yaw_ + 0.5 * wrapped(yaw - section_start_yaw_));
  section_start_ = p_enu;
  section_start_yaw_ = yaw;
}

void HeadingCheck::update(const Eigen::Vector3d& step, double yaw) {
  const double size = std::abs(wrapped(std::atan2(step.y(), step.x()) - yaw));
  agreements_ = size < kAgreement ? agreements_ + 1 : 0;
  contradictions_ = size > kContradiction ? contradictions_ + 1 : 0;
  if (agreements_ >= kMinCount) agrees_ = true;
  if (contradictions_ >= kMinCount) agrees_ = false;
}

}  // namespace lidar_mapping::preprocessing
