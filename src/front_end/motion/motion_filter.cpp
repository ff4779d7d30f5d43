// SPDX-License-Identifier: BSD-3-Clause
#include "motion/motion_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "lidar_mapping/common/covariance.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Variance of the position after an unknown acceleration a for t seconds, in units of a^2 t^4: 1/4
/// for a constant one, 1/3 for white noise with the same effect on the velocity. Chosen between
/// them: with 1/4, velocity and position are correlated so strongly that an error of one scan
/// returns with the opposite sign in the next.
constexpr double kPositionFactor = 0.28;
/// Fraction by which a smaller acceleration is adopted per scan. Chosen: after a second without one
/// the next is still expected.
constexpr double kAccelerationDecay = 0.1;
/// Lower bound in units of the upper one. Chosen: so slowly a vehicle at rest or in steady motion
/// may begin to change it without being doubted.
constexpr double kMinAccelerationFraction = 0.025;
/// Fraction of the forecast's mean squared error that the covariance of the twist does not contain.
/// Chosen: most of it is the noise of matches, which the covariance contains already.
constexpr double kForecastFraction = 0.3;

/// Standard deviation of a pose relative to the part of the map that was inserted with it. Chosen:
/// half of the range noise of a LiDAR (0.02 m), of which the mean of many points counts.
constexpr double kAnchorSigma = 0.01;  // m

// How long a motion goes on after it was last observed, s. Chosen: within this time a vehicle comes
// to a stop or turns off.
constexpr double kContinuedMotion = 5.0;
/// How long it goes on tilting, s. Chosen: roads and bodies sway back within a second.
constexpr double kContinuedTilting = 1.0;
/// How long an acceleration goes on, s. Chosen: a vehicle that brakes stops, it does not reverse.
constexpr double kContinuedAcceleration = 1.0;
/// The covariance of the pose grows for as long, s. Chosen: by then the pose may be anywhere, and
/// the inverse of a larger covariance would be inexact.
constexpr double kGrowingCovariance = 600.0;

/// The time, or the limit if it is longer, in the same direction.
double at_most(double limit, double seconds) { return std::clamp(seconds, -limit, limit); }

/// How long each component of a twist goes on within this time, s.
Vector6d continued_seconds(double seconds) {
  Vector6d times = Vector6d::Constant(continued_time(seconds));
  times.segment<2>(3).setConstant(at_most(kContinuedTilting, seconds));
  return times;
}

/// Derivative of the state after `seconds` with respect to the state now.
Matrix12d transition(const Vector6d& twist, double seconds) {
  Matrix12d F = Matrix12d::Identity();
  F.topLeftCorner<6, 6>() = adjoint(continued(Pose{}, twist, seconds).inverse());
  F.topRightCorner<6, 6>() = continued_seconds(seconds).asDiagonal();
  return F;
}

}  // namespace

Pose moved(const Pose& T, const Vector6d& twist, double seconds) {
  const Eigen::Vector3d rotation = seconds * twist.tail<3>();
  const double angle = rotation.norm();
  // The left Jacobian of SO(3) takes into account that the axes rotate during the motion.
  const Eigen::Matrix3d w = skew(rotation);
  const double a =
      angle < 1e-4 ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double b = angle < 1e-4 ? 1.0 / 6.0 - angle * angle / 120.0
                                : (angle - std::sin(angle)) / (angle * angle * angle);
  const Eigen::Matrix3d J = Eigen::Matrix3d::Identity() + a * w + b * w * w;
  return T * Pose{exp_so3(rotation), J * (seconds * twist.head<3>())};
}

double continued_time(double seconds) { return at_most(kContinuedMotion, seconds); }

Pose continued(const Pose& T, const Vector6d& twist, double seconds) {
  const double tilting = at_most(kContinuedTilting, seconds);
  const Pose tilted = moved(T, twist, tilting);
  if (tilting == seconds) return tilted;
  Vector6d level = twist;
  level.segment<2>(3).setZero();
  return moved(tilted, level, continued_time(seconds) - tilting);
}

MotionState steadily_accelerated(const MotionState& state, const Vector6d& acceleration,
                                 double duration, double seconds) {
  // The straight line that fits the parabola a t^2 / 2 best passes through its mean, a duration^2 /
  // 24.
  const double bend = 0.5 * seconds * seconds - duration * duration / 24.0;
  const Pose straight = moved(state.T_map_sensor, state.twist, seconds);
  return {moved(straight, acceleration, bend), state.twist + seconds * acceleration};
}

Vector6d twist_between(const Pose& a, const Pose& b, double seconds) {
  const Pose step = a.inverse() * b;
  Vector6d turn = Vector6d::Zero();
  turn.tail<3>() = log_so3(step.rotation);
  Eigen::Matrix3d J;
  for (int axis = 0; axis < 3; ++axis) {
    Vector6d unit = turn;
    unit[axis] = 1.0;
    J.col(axis) = moved(Pose::Identity(), unit, 1.0).translation;
  }
  Vector6d twist = turn;
  twist.head<3>() = J.inverse() * step.translation;
  return twist / seconds;
}

Covariance6 pose_covariance(const Matrix12d& covariance, const Vector6d& twist, double seconds) {
  const Matrix12d F = transition(twist, seconds);
  const Matrix12d later = F * covariance * F.transpose();
  return later.topLeftCorner<6, 6>();
}

Vector6d gap_between(const PreviousMatch& previous, const MotionState& current) {
  const double half = 0.5 * previous.seconds_before;
  return difference(continued(current.T_map_sensor, current.twist, -half),
                    continued(previous.state.T_map_sensor, previous.state.twist, half));
}

MotionFilter::MotionFilter(double acceleration_sigma, double angular_acceleration_sigma)
    : linear_{acceleration_sigma, acceleration_sigma},
      angular_{angular_acceleration_sigma, angular_acceleration_sigma},
      forecast_(acceleration_sigma) {}

/// A larger acceleration is adopted at once, a smaller one slowly.
void MotionFilter::AccelerationSigma::update(double acceleration) {
  const double wanted = std::clamp(acceleration, kMinAccelerationFraction * max_sigma, max_sigma);
  sigma = std::max(wanted, sigma + kAccelerationDecay * (wanted - sigma));
}

void MotionFilter::reset(const Pose& pose, double speed_sigma, double rate_sigma) {
  Matrix12d covariance = Matrix12d::Zero();
  // The first pose is known by definition.
  covariance.topLeftCorner<6, 6>() = diagonal_covariance(1e-4, 1e-5);
  covariance.bottomRightCorner<6, 6>() = diagonal_covariance(speed_sigma, rate_sigma);
  restart({pose, Vector6d::Zero()}, covariance);
  linear_.sigma = kMinAccelerationFraction * linear_.max_sigma;
  angular_.sigma = kMinAccelerationFraction * angular_.max_sigma;
}

void MotionFilter::restart(const MotionState& state, const Matrix12d& covariance) {
  forecast_ = TwistPredictor(linear_.max_sigma);
  corrected_ = false;
  acceleration_.setZero();
  last_corrected_ = state;
  has_match_ = false;
  previous_match_.reset();
  since_corrected_ = step_seconds_ = 0.0;
  turning_measured_ = false;
  state_ = state;
  covariance_ = covariance;
}

void MotionFilter::apply_forecast(double seconds) {
  state_.twist = forecast_.next(at_most(kContinuedAcceleration, seconds));
  const Eigen::Vector2d more = kForecastFraction * forecast_.variance();
  covariance_.diagonal().segment<3>(6).array() += more[0];
  covariance_.diagonal().segment<3>(9).array() += more[1];
}

void MotionFilter::apply_turning(const MeasuredTurning& turning) {
  state_.twist.tail<3>() = turning.between;
  covariance_.middleRows<3>(9).setZero();
  covariance_.middleCols<3>(9).setZero();
  covariance_.diagonal().segment<3>(9).setConstant(turning.sigma * turning.sigma);
}

void MotionFilter::predict(double seconds, const std::optional<MeasuredTurning>& turning) {
  step_seconds_ = seconds;
  since_corrected_ += seconds;
  acceleration_.setZero();
  previous_match_.reset();
  const bool forecast = std::exchange(corrected_, false);
  if (forecast) apply_forecast(seconds);
  forecast_state_ = {continued(state_.T_map_sensor, state_.twist, seconds), state_.twist};
  if (turning) apply_turning(*turning);
  turning_measured_ = turning && turning->uniform;
  grow_covariance(seconds, turning.has_value());
  // A rotation is measured only between sweeps that adjoin.
  state_.T_map_sensor = turning ? moved(state_.T_map_sensor, state_.twist, seconds)
                                : continued(state_.T_map_sensor, state_.twist, seconds);
  if (forecast) {
    state_.twist = forecast_state_.twist =
        forecast_.at_end_of_next(at_most(kContinuedAcceleration, seconds));
  }
  if (turning) state_.twist.tail<3>() = turning->within;
}

/// After a gap the pose is as uncertain as the gap is long, but the twist tells of the last seconds
/// only: what is measured of it then moves the pose by no more.
void MotionFilter::grow_covariance(double seconds, bool turning_measured) {
  const Matrix12d F = transition(state_.twist, seconds);
  Vector6d variance;
  variance.head<3>().setConstant(linear_.sigma * linear_.sigma);
  variance.tail<3>().setConstant(turning_measured ? 0.0 : angular_.sigma * angular_.sigma);
  const double t2 = std::pow(at_most(kGrowingCovariance, seconds), 2);
  const Vector6d times = continued_seconds(seconds);
  const Vector6d of_twist = times.cwiseAbs2().cwiseProduct(variance);
  const Vector6d common = (0.5 * times.cwiseAbs2()).cwiseProduct(times).cwiseProduct(variance);
  covariance_ = F * covariance_ * F.transpose();
  covariance_.topLeftCorner<6, 6>().diagonal() += kPositionFactor * t2 * t2 * variance;
  covariance_.topRightCorner<6, 6>().diagonal() += common;
  covariance_.bottomLeftCorner<6, 6>().diagonal() += common;
  covariance_.bottomRightCorner<6, 6>().diagonal() += of_twist;
}

MotionFilter MotionFilter::with_high_process_noise() const {
  MotionFilter high_noise = *this;
  high_noise.linear_.sigma = linear_.max_sigma;
  high_noise.angular_.sigma = angular_.max_sigma;
  return high_noise;
}

/// Scalar Kalman update in Joseph's form, which stays symmetric and positive.
void MotionFilter::measure(const Vector12d& row, double innovation, double sigma) {
  const double variance = sigma * sigma;
  const Vector12d gain = covariance_ * row / (row.dot(covariance_ * row) + variance);
  state_ = registration::perturbed(state_, Vector12d(gain * innovation));
  const Matrix12d rest = Matrix12d::Identity() - gain * row.transpose();
  covariance_ = rest * covariance_ * rest.transpose() + variance * gain * gain.transpose();
}

void MotionFilter::measure_rate(const Eigen::Vector3d& angular_velocity, double sigma) {
  turning_measured_ = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double innovation = angular_velocity[axis] - state_.twist[3 + axis];
    measure(Vector12d::Unit(9 + axis), innovation, sigma);
  }
}

void MotionFilter::measure_velocity(const Eigen::Vector3d& linear_velocity, double sigma) {
  for (int axis = 0; axis < 3; ++axis) {
    measure(Vector12d::Unit(6 + axis), linear_velocity[axis] - state_.twist[axis], sigma);
  }
}

void MotionFilter::measure_planar_pose(const Pose& pose, double sigma, double angle_sigma) {
  for (const int axis : {0, 1, 5}) {
    const double innovation = difference(state_.T_map_sensor, pose)[axis];
    measure(Vector12d::Unit(axis), innovation, axis < 3 ? sigma : angle_sigma);
  }
}

void MotionFilter::slow_down(double seconds, double time_constant) {
  state_.twist *= std::exp(-seconds / time_constant);
}

/// A real acceleration changes both twist and displacement; noise seldom changes both.
void MotionFilter::update_acceleration_sigmas(const MotionState& state,
                                              const Eigen::Matrix3d& observed) {
  if (step_seconds_ == 0.0) return;
  const double to_acceleration = 2.0 / (step_seconds_ * step_seconds_);
  const Vector6d of_twist_change = (state.twist - state_.twist) / step_seconds_;
  const Vector6d of_displacement =
      difference(state_.T_map_sensor, state.T_map_sensor) * to_acceleration;
  linear_.update(std::min((observed * of_twist_change.head<3>()).norm(),
                          (observed * of_displacement.head<3>()).norm()));
  // The rotation is compared without the gyro, because a gyro may fail at any time.
  const MotionState& turned = turning_measured_ ? forecast_state_ : state_;
  const Vector6d turn = difference(turned.T_map_sensor, state.T_map_sensor) * to_acceleration;
  const double twist_change = (state.twist - turned.twist).tail<3>().norm();
  // The time is negative where scans are matched from the latest to the first.
  angular_.update(std::min(twist_change / std::abs(step_seconds_), turn.tail<3>().norm()));
}

/// A jump of the pose, for example when tracking is regained, is not an acceleration.
Vector6d MotionFilter::plausible_acceleration(const Vector6d& acceleration,
                                              const Eigen::Matrix3d& observed) const {
  Vector6d plausible = Vector6d::Zero();
  const Eigen::Vector3d linear = observed * acceleration.head<3>();
  if (linear.norm() < linear_.max_sigma) plausible.head<3>() = linear;
  const Eigen::Vector3d angular = acceleration.tail<3>();
  if (angular.norm() < angular_.max_sigma) plausible.tail<3>() = angular;
  return plausible;
}

void MotionFilter::correct(const MotionState& state, const Matrix12d& covariance,
                           const Eigen::Matrix3d& observed) {
  update_acceleration_sigmas(state, observed);
  if (since_corrected_ != 0.0) {
    previous_match_ = last_match();
    const Vector6d mean_twist =
        twist_between(last_corrected_.T_map_sensor, state.T_map_sensor, since_corrected_);
    forecast_.update(mean_twist, state.twist, since_corrected_, observed);
    // The mean twist refers to the middle of the step, half a step ago.
    const Vector6d change = forecast_.change_persistence().cwiseProduct(state.twist - mean_twist);
    acceleration_ = plausible_acceleration(2.0 / since_corrected_ * change, observed);
    // A measured rotation has been removed from the sweep as far as it was not uniform.
    if (turning_measured_) acceleration_.tail<3>().setZero();
    corrected_ = true;
  }
  last_corrected_ = state;
  has_match_ = true;
  since_corrected_ = 0.0;
  state_ = state;
  covariance_ = 0.5 * (covariance + covariance.transpose());
}

std::optional<PreviousMatch> MotionFilter::last_match() const {
  if (!has_match_) return std::nullopt;
  return PreviousMatch{last_corrected_, since_corrected_};
}

void MotionFilter::anchor(const std::vector<Eigen::Vector3d>& directions) {
  if (directions.empty()) return;
  Matrix12d rest = Matrix12d::Identity();
  Matrix12d known = Matrix12d::Zero();
  for (const Eigen::Vector3d& d : directions) {
    rest.topLeftCorner<3, 3>() -= d * d.transpose();
    known.topLeftCorner<3, 3>() += kAnchorSigma * kAnchorSigma * d * d.transpose();
  }
  covariance_ = rest * covariance_ * rest.transpose() + known;
}

MotionBelief MotionFilter::belief() const { return {state_, covariance_.inverse()}; }

}  // namespace lidar_mapping::front_end
