// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/gnss_gate.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kSigmas = 3.0;  // 99.7 % of a normal distribution, along an axis
// m that are always allowed. Chosen: smaller jumps do little harm, and dead reckoning errs by as
// much.
constexpr double kTolerance = 0.5;
// Of the path length since the last good fix: drift of dead reckoning by a gyro and wheels. Chosen
// above the scale error of a wheel (1 %).
constexpr double kDriftFraction = 0.012;
// Height per path length, as dead reckoning takes the vehicle as level. Chosen: the steepest roads
// that design standards allow are about as steep.
constexpr double kMaxGrade = 0.12;
// m, path length that is aligned with the fixes. Chosen: long enough for a heading, short enough
// for the drift of dead reckoning.
constexpr double kWindowLength = 60.0;
// m without a good fix after which any is accepted. Chosen: dead reckoning has drifted by the usual
// size of a jump then (kDriftFraction: 1.8 m), and the old fixes do not determine the new ones.
constexpr double kMaxPathWithoutFix = 150.0;
// m, path length between the fixes that are used: nearer ones add time and no information. Chosen.
constexpr double kMinMatchSpacing = 0.5;
// Extent of the window, m and in standard deviations of the fixes, from which on its heading is
// estimated. Chosen: the heading is then good to about 1 / 5 rad or better.
constexpr double kMinExtentForRotation = 5.0;
constexpr double kMinSigmasForRotation = 5.0;

Pose leveled(const Pose& pose) {
  const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitX();
  return {exp_so3({0.0, 0.0, std::atan2(ahead.y(), ahead.x())}), pose.translation};
}

std::string jump_text(const char* what, double distance, double limit) {
  return formatted("a jump: %.1f m %s, %.1f m allowed", distance, what, limit);
}

}  // namespace

std::string GnssGate::check(const LocalFix& fix, const Eigen::Vector3d& p_base_antenna,
                            const std::optional<Pose>& motion) {
  dead_reckon(p_base_antenna, motion);
  const Eigen::Vector3d p_dr = T_dr_base_ * p_base_antenna;
  const std::string problem = problem_with(fix, p_dr);
  if (problem.empty()) add_match(fix, p_dr);
  return problem;
}

void GnssGate::dead_reckon(const Eigen::Vector3d& p_base_antenna,
                           const std::optional<Pose>& motion) {
  if (!motion) {
    matches_.clear();
    has_motion_ = false;
    return;
  }
  const Eigen::Vector3d before = T_dr_base_ * p_base_antenna;
  T_dr_base_ = leveled(T_dr_base_ * *motion);
  path_length_ += (T_dr_base_ * p_base_antenna - before).norm();
  has_motion_ = true;
}

std::optional<Pose> GnssGate::dead_reckoning() const {
  if (!has_motion_) return std::nullopt;
  return T_dr_base_;
}

std::optional<GnssGate::Alignment> GnssGate::alignment() const {
  if (matches_.size() < 3) return std::nullopt;
  Alignment result;
  result.center_dr.setZero();
  result.center_enu.setZero();
  double sigma = 0.0;
  for (const Match& match : matches_) {
    result.center_dr += match.p_dr.head<2>();
    result.center_enu += match.p_enu.head<2>();
    sigma = std::max(sigma, match.sigma);
  }
  const auto count = static_cast<double>(matches_.size());
  result.center_dr /= count;
  result.center_enu /= count;
  double along = 0.0, across = 0.0, extent = 0.0;
  for (const Match& match : matches_) {
    const Eigen::Vector2d a = match.p_dr.head<2>() - result.center_dr;
    const Eigen::Vector2d b = match.p_enu.head<2>() - result.center_enu;
    along += a.dot(b);
    across += a.x() * b.y() - a.y() * b.x();
    extent = std::max(extent, a.norm());
  }
  if (extent < std::max(kMinExtentForRotation, kMinSigmasForRotation * sigma)) return std::nullopt;
  result.R_enu_dr = Eigen::Rotation2Dd(std::atan2(across, along)).toRotationMatrix();
  return result;
}

std::string GnssGate::problem_with(const LocalFix& fix, const Eigen::Vector3d& p_dr) const {
  if (!last_good_) return "";
  const Eigen::Vector3d step = step_between(*last_good_, fix);
  const double sigma =
      std::hypot(horizontal_sigma(fix.covariance), horizontal_sigma(last_good_->covariance));
  const double seconds = to_seconds(fix.stamp - last_good_->stamp);
  const double max_distance = kMaxRoadSpeed * seconds + kSigmas * sigma + kTolerance;
  if (step.norm() > max_distance) return jump_text("since the last fix", step.norm(), max_distance);
  if (!has_motion_ || matches_.empty()) return "";
  const double path_length = path_length_ - last_match_.path_length;
  if (path_length > kMaxPathWithoutFix) return "";
  const double sigma_z = std::sqrt(fix.covariance(2, 2) + last_good_->covariance(2, 2));
  const double limit_z = kSigmas * sigma_z + kMaxGrade * path_length + 2.0 * kTolerance;
  if (std::abs(step.z()) > limit_z) return jump_text("in height", std::abs(step.z()), limit_z);
  const double limit = kSigmas * std::hypot(sigma, kDriftFraction * path_length) + kTolerance;
  if (const auto aligned = alignment()) {
    const Eigen::Vector2d expected =
        aligned->center_enu + aligned->R_enu_dr * (p_dr.head<2>() - aligned->center_dr);
    const double off = (fix.p_enu.head<2>() - expected).norm();
    return off > limit ? jump_text("to the side of the measured path", off, limit) : "";
  }
  const double distance_travelled = (p_dr - last_match_.p_dr).head<2>().norm();
  const double difference = std::abs(step.head<2>().norm() - distance_travelled);
  return difference > limit ? jump_text("longer or shorter than the driven path", difference, limit)
                            : "";
}

void GnssGate::add_match(const LocalFix& fix, const Eigen::Vector3d& p_dr) {
  last_good_ = fix;
  if (path_length_ - last_match_.path_length > kMaxPathWithoutFix) matches_.clear();
  last_match_ = {p_dr, fix.p_enu, horizontal_sigma(fix.covariance), path_length_};
  const bool is_standing =
      !matches_.empty() && path_length_ - matches_.back().path_length < kMinMatchSpacing;
  if (!is_standing) matches_.push_back(last_match_);
  while (path_length_ - matches_.front().path_length > kWindowLength) matches_.pop_front();
}

}  // namespace lidar_mapping::preprocessing
