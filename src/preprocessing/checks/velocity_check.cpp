// SPDX-License-Identifier: BSD-3-Clause
#include "checks/velocity_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// s between scans or fixes; longer pauses begin a new section. Chosen: the slowest usual rate of
// fixes.
constexpr double kMaxGap = 1.0;
// s over which rotations are compared. Chosen: a bend lasts longer, and the noise of single samples
// averages out.
constexpr double kTurnDuration = 1.0;
// m/s. Chosen: at lower speeds the direction is not reliable; noise of 0.1 m/s turns it by 3
// degrees.
constexpr double kMinSpeedForDirection = 2.0;
// Sum of squares, rad^2: a bend of 90 degrees in three seconds. Chosen: with less the noise of the
// direction could decide.
constexpr double kMinSquaredTurning = 0.5;
// Factor of the old sums for each new turn: the last 50 turns count. Chosen.
constexpr double kForgetting = 0.98;
// Length of a section between fixes, m and in standard deviations. Chosen: the scale is then good
// to a tenth (sqrt(2) / 20).
constexpr double kMinSectionLength = 2.0;
constexpr double kMinSigmasOfSection = 20.0;
// s for a section; a vehicle that needs longer hardly moves. Chosen.
constexpr double kMaxSectionDuration = 20.0;
// For a median without the outermost two; chosen: more decide later.
constexpr std::size_t kSections = 5;
// Of the scale, largest difference of the middle values. Chosen: twice the error of one (a tenth).
constexpr double kMaxScaleDifference = 0.2;

double angle_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
}

}  // namespace

bool is_true_scale(double scale) { return scale > 0.7 && scale < 1.4; }

bool is_kilometres_per_hour(double scale) { return scale > 3.2 && scale < 4.0; }

std::string scale_sentence(double scale) {
  return formatted("its speeds are %.2f times those of the fixes%s", scale,
                   is_kilometres_per_hour(scale) ? ": they are in km/h" : "");
}

void VelocityCheck::add_turn_rate(Stamp stamp, const Eigen::Vector3d& velocity, double rate) {
  if (turn_ && (stamp <= turn_->last || to_seconds(stamp - turn_->last) > kMaxGap)) {
    turn_.reset();
  }
  const Eigen::Vector2d level = velocity.head<2>();
  if (level.norm() < kMinSpeedForDirection) return turn_.reset();
  if (turn_) {
    turn_->angle += rate * to_seconds(stamp - turn_->last);
    turn_->last = stamp;
    if (to_seconds(stamp - turn_->begin) < kTurnDuration) return;
    squared_angles_ = kForgetting * squared_angles_ + turn_->angle * turn_->angle;
    angle_products_ =
        kForgetting * angle_products_ + turn_->angle * angle_between(turn_->velocity, level);
  }
  turn_ = Turn{stamp, stamp, level, 0.0};
}

void VelocityCheck::add_fix(const LocalFix& fix, double speed) {
  if (section_ &&
      (fix.stamp <= section_->last || to_seconds(fix.stamp - section_->last) > kMaxGap ||
       to_seconds(fix.stamp - section_->from.stamp) > kMaxSectionDuration)) {
    section_.reset();
  }
  if (section_) {
    section_->distance_travelled += speed * to_seconds(fix.stamp - section_->last);
    section_->last = fix.stamp;
    const double length = (fix.p_enu - section_->from.p_enu).head<2>().norm();
    const double sigma = horizontal_sigma(fix.covariance);
    if (length < std::max(kMinSectionLength, kMinSigmasOfSection * sigma)) return;
    scales_.push_back(section_->distance_travelled / length);
    if (scales_.size() > kSections) scales_.pop_front();
  }
  section_ = Section{fix, fix.stamp, 0.0};
}

/// The median, if the other values agree with it; jumps of fixes do not agree.
std::optional<double> VelocityCheck::consistent_scale() const {
  if (scales_.size() < kSections) return std::nullopt;
  // All in order, and not median() of common/order_statistics.hpp: the ends are needed, too.
  std::array<double, kSections> sorted{};
  std::copy(scales_.begin(), scales_.end(), sorted.begin());
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[kSections / 2];
  if (sorted[kSections - 2] - sorted[1] > kMaxScaleDifference * median) return std::nullopt;
  return median;
}

VelocityProblem VelocityCheck::problem(const Eigen::Vector3d& velocity) const {
  const auto scale = consistent_scale();
  if (scale && !is_true_scale(*scale)) return VelocityProblem::kUnit;
  // In fixed axes the direction rotates by the same angle as the vehicle, in the vehicle's own axes
  // not at all. For a flying vehicle that yaws on a straight path it rotates back.
  if (squared_angles_ > kMinSquaredTurning) {
    return angle_products_ > 0.5 * squared_angles_ ? VelocityProblem::kAxes
                                                   : VelocityProblem::kNone;
  }
  const bool points_aside =
      std::abs(velocity.y()) > std::max(std::abs(velocity.x()), kMinSpeedForDirection);
  return points_aside ? VelocityProblem::kAside : VelocityProblem::kNone;
}

std::string VelocityCheck::sentence(VelocityProblem problem) const {
  switch (problem) {
    case VelocityProblem::kNone:
      return "";
    case VelocityProblem::kUnit:
      return scale_sentence(consistent_scale().value_or(0.0)) +
             "; it is not used until they agree (publish m/s, or set use_velocity to false)";
    case VelocityProblem::kAxes:
      return "its direction turns with the vehicle, as in East-North-Up; it is not used until it "
             "is in the axes of its frame (publish it in these, or set use_velocity to false)";
    case VelocityProblem::kAside:
      return "it points aside more than ahead, as in East-North-Up or with a wrong transform; it "
             "is not used before a turn has shown that it is in the axes of its frame";
  }
  return "";
}

}  // namespace lidar_mapping::preprocessing
