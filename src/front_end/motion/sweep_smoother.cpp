// SPDX-License-Identifier: BSD-3-Clause
#include "motion/sweep_smoother.hpp"

#include <algorithm>

#include "judgement/reported_covariance.hpp"
#include "motion/deviation_filter.hpp"
#include "motion/gyro_validator.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Weight of the points' normal equations, times the variance of their residuals: below one because
/// neighbouring points err together. Measured on 21 drives of all carriers: between 0.1 and 0.2 the
/// errors of steps change by 1 %, at 0.05 or 0.4 they are 3 to 5 % larger.
constexpr double kDataWeight = 0.15;

/// Weight of the newest sweep in running means. Chosen: the mean follows a change of gait within
/// ten sweeps.
constexpr double kLearningRate = 0.1;
/// Largest change of the twist during a sweep that counts as motion and not as a match that was
/// off, as at the begin of a map: m/s, rad/s. Chosen: what a hard footfall of a legged robot does.
constexpr double kMaxTwistChange = 1.0;
/// Largest innovation that counts for the scale, in standard deviations. Chosen: a single match
/// that is off must not govern the mean.
constexpr double kMaxInnovation = 5.0;
/// A smaller expected squared innovation is none: that of a measured rotation (m^2, rad^2). Chosen
/// far below the noise of matches, and above zero, because it is a divisor.
constexpr double kLeastInnovation = 1e-15;
/// Part of the covariance that is reported. Measured: with it the squared errors of steps, divided
/// by their covariance, are 0.6 to 1.1 in six drives of cars and a walk, and 0.4 to 3.4 in 21
/// drives of all carriers.
constexpr double kReportedFraction = 0.3;
/// Least noise, linear (m^2/s^3) and angular (rad^2/s^3), so that a motion that has been steady may
/// change: by 1 cm/s and 3 mrad/s within 0.1 s. Chosen.
const Eigen::Vector2d kMinNoise(1e-3, 1e-4);

/// A sweep is not smoothed if its measured rotation contradicts the previous sweep by more than
/// this, in squared standard deviations: a wrong rotation would bend the translation. Chosen: two
/// standard deviations; gyros that are right have 0.6 at most (see gyro_validator.cpp).
constexpr double kMaxContradiction = 4.0;
/// The least rate that shows whether a gyro is right, rad/s. Chosen: five times kLeastGyroSigma.
constexpr double kLeastTurn = 0.1;

/// Sweeps whose middles are farther apart than this number of sweep durations do not touch. Chosen
/// between 1, of sweeps that adjoin, and 2, with one missing.
constexpr double kMaxDistance = 1.3;

Vector6d per_axis(const Eigen::Vector2d& linear_and_angular) {
  Vector6d values;
  values << Eigen::Vector3d::Constant(linear_and_angular[0]),
      Eigen::Vector3d::Constant(linear_and_angular[1]);
  return values;
}

/// Means of the three linear and of the three angular axes.
Eigen::Vector2d linear_and_angular(const Vector6d& values) {
  return {values.head<3>().mean(), values.tail<3>().mean()};
}

/// The same matrix for both halves of a state.
Matrix12d for_pose_and_twist(const Matrix6d& matrix) {
  Matrix12d both = Matrix12d::Zero();
  both.topLeftCorner<6, 6>() = both.bottomRightCorner<6, 6>() = matrix;
  return both;
}

/// The weights of begin, middle and end in the parabola through them, u half durations after the
/// middle.
Eigen::Vector3d parabola_at(double u) {
  return {0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)};
}

const Eigen::Vector3d kMiddleAlone(0.0, 1.0, 0.0);

/// Deviation at the begin of a sweep and its change per second.
struct Begin {
  Vector12d state;
  Matrix12d covariance;
};

/// A measured rotation is more precise than what the slices say: the deviation is a translation.
void pin_rotation(Begin& begin) {
  for (const int rotation : {3, 9}) {
    begin.state.segment<3>(rotation).setZero();
    begin.covariance.middleRows<3>(rotation).setZero();
    begin.covariance.middleCols<3>(rotation).setZero();
  }
}

/// The end of a sweep whose pose and twist are those of the match.
SweepEnd end_of_match(const MotionFilter& filter, double half) {
  const MotionState& match = filter.state();
  const Pose to_end = moved(Pose::Identity(), match.twist, half);
  Matrix12d F = Matrix12d::Identity();
  F.topLeftCorner<6, 6>() = adjoint(to_end.inverse());
  F.topRightCorner<6, 6>() = half * Matrix6d::Identity();
  return {{match.T_map_sensor * to_end, match.twist}, F * filter.covariance() * F.transpose()};
}

/// The begin of a sweep as the end of the previous one, as deviation from the match.
Begin begin_after(const SweepEnd& previous, const MotionFilter& filter, double duration) {
  const MotionState& match = filter.state();
  const Pose to_begin = moved(Pose::Identity(), match.twist, -0.5 * duration);
  const Pose pose = moved(previous.state.T_map_sensor, previous.state.twist,
                          filter.previous_match()->seconds_before - duration);
  const Matrix6d to_middle = adjoint(to_begin);
  Begin begin;
  begin.state << difference(Pose::Identity(),
                            match.T_map_sensor.inverse() * pose * to_begin.inverse()),
      to_middle * (previous.state.twist - match.twist);
  const Matrix12d A = for_pose_and_twist(to_middle);
  begin.covariance = A * previous.covariance * A.transpose();
  return begin;
}

/// By the measured rotation the deviation at the begin is zero, by the previous sweep it is not:
/// its square, divided by its covariance.
double contradiction_at(const Begin& begin, const MotionFilter& filter, double duration) {
  const Covariance6 of_match =
      pose_covariance(filter.covariance(), filter.state().twist, -0.5 * duration);
  const Covariance6 expected = begin.covariance.topLeftCorner<6, 6>() + of_match;
  return begin.state.segment<3>(3).squaredNorm() / expected.bottomRightCorner<3, 3>().trace();
}

SweepEnd end_after(const DeviationFilter& deviation, const MotionState& match, double half) {
  const Pose to_end = moved(Pose::Identity(), match.twist, half);
  const Vector12d state = deviation.state();
  const Matrix6d from_middle = adjoint(to_end.inverse());
  const Matrix12d A = for_pose_and_twist(from_middle);
  return {{perturbed(match.T_map_sensor, Vector6d(state.head<6>())) * to_end,
           match.twist + from_middle * state.tail<6>()},
          A * deviation.covariance() * A.transpose()};
}

/// Takes rotation and rate of turn from another covariance of pose and twist.
void set_rotation(const Matrix12d& from, Matrix12d& covariance) {
  for (const int rotation : {3, 9}) {
    covariance.block<3, 3>(rotation, rotation) = from.block<3, 3>(rotation, rotation);
  }
}

bool touches_previous(const MotionFilter& filter, double duration) {
  const std::optional<PreviousMatch>& previous = filter.previous_match();
  return previous && previous->seconds_before < kMaxDistance * duration;
}

}  // namespace

Matrix12d without_smoothed_twist(const Matrix12d& of_match, bool rotation_measured) {
  const int smoothed = rotation_measured ? 3 : 6;
  Matrix12d covariance = of_match;
  covariance.middleRows(6, smoothed).setZero();
  covariance.middleCols(6, smoothed).setZero();
  return covariance;
}

double SweepSmoother::newest_weight() const {
  return std::max(kLearningRate, 1.0 / learned_sweeps_);
}

void SweepSmoother::reset() { *this = SweepSmoother(); }

void SweepSmoother::add(const SweepMatcher::Found& found, const MotionFilter& filter,
                        double duration) {
  deviations_.reset();
  contradiction_.reset();
  if (duration <= 0.0 || !found.degenerate_directions.empty() || !filter.previous_match())
    return end_.reset();
  if (end_ && touches_previous(filter, duration)) {
    learn_noise(filter, duration);
    smooth(found, filter, duration);
  } else {
    end_ = end_of_match(filter, 0.5 * duration);
  }
}

/// With white noise of density q as acceleration since the end of the previous sweep, the error of
/// the predicted pose in the middle and that of the predicted mean twist have the covariance
/// 2/15 q duration^2. The noise of the match is not in it, because it is independent in both.
void SweepSmoother::learn_noise(const MotionFilter& filter, double duration) {
  const MotionState& match = filter.state();
  const double seconds = filter.previous_match()->seconds_before - 0.5 * duration;
  const Vector6d pose_error =
      difference(moved(end_->state.T_map_sensor, end_->state.twist, seconds), match.T_map_sensor);
  const Vector6d product = pose_error.cwiseProduct(match.twist - end_->state.twist);
  const Matrix6d explained = end_->covariance.topRightCorner<6, 6>() +
                             seconds * end_->covariance.bottomRightCorner<6, 6>();
  const Vector6d density = (product - explained.diagonal()) / (2.0 / 15.0 * duration * duration);
  ++learned_sweeps_;
  const double most = kMaxTwistChange * kMaxTwistChange / duration;
  const Eigen::Vector2d newest = linear_and_angular(density).cwiseMax(0.0).cwiseMin(most);
  noise_ += newest_weight() * (newest - noise_);
}

void SweepSmoother::smooth(const SweepMatcher::Found& found, const MotionFilter& filter,
                           double duration) {
  const NdtMatch& match = found.match;
  Begin begin = begin_after(*end_, filter, duration);
  Vector6d noise = per_axis(noise_.cwiseMax(kMinNoise));
  if (filter.is_rotation_measured()) {
    contradiction_ = contradiction_at(begin, filter, duration);
    if (contradiction_ > kMaxContradiction) return end_.reset();
    pin_rotation(begin);
    noise.tail<3>().setZero();
  }
  DeviationFilter deviation(noise, filter.acceleration());
  deviation.begin(0.5 * duration, begin.state, begin.covariance);
  const SweepDeviations before = deviation.deviations();
  const double weight = kDataWeight / credible_residual_variance(match);
  for (const registration::NdtSlice& slice : match.slices) {
    deviation.predict(slice.time);
    deviation.measure(slice.part, weight);
  }
  deviation.predict(0.5 * duration);
  end_ = end_after(deviation, filter.state(), 0.5 * duration);
  if (filter.is_rotation_measured())
    set_rotation(end_of_match(filter, 0.5 * duration).covariance, end_->covariance);
  deviations_ = deviation.deviations();
  learn_scale(before, *deviations_);
  usual_covariance_ = scaled(deviations_->covariance_of(parabola_at(-1.0) - kMiddleAlone));
}

/// The sweep moves the deviation at its begin by as much as it lessens its covariance, if this is
/// true: else all covariances are that much too small or too large (normalised innovation).
void SweepSmoother::learn_scale(const SweepDeviations& before, const SweepDeviations& after) {
  const Vector6d moved = (after.poses - before.poses).head<6>();
  const Vector6d lessened = (before.covariance - after.covariance).diagonal().head<6>();
  const Eigen::Vector2d expected = linear_and_angular(lessened);
  const Eigen::Vector2d squared =
      linear_and_angular(moved.cwiseAbs2()).cwiseMin(kMaxInnovation * kMaxInnovation * expected);
  squared_innovation_ += newest_weight() * (squared - squared_innovation_);
  expected_innovation_ += newest_weight() * (expected - expected_innovation_);
}

std::optional<double> SweepSmoother::contradiction_to(const Eigen::Vector3d& rate,
                                                      const MotionFilter& filter,
                                                      double duration) const {
  if (contradiction_) return contradiction_;
  if (!is_smoothed(filter)) return std::nullopt;
  const Eigen::Vector3d along(-1.0, 0.0, 1.0);
  const Eigen::Vector3d smoothed =
      filter.state().twist.tail<3>() + deviations_->combined(along).tail<3>() / duration;
  if (smoothed.norm() < kLeastTurn) return std::nullopt;
  const double variance =
      deviations_->covariance_of(along).bottomRightCorner<3, 3>().trace() / (duration * duration);
  return (smoothed - rate).squaredNorm() / (variance + 3.0 * kLeastGyroSigma * kLeastGyroSigma);
}

Covariance6 SweepSmoother::scaled(const Covariance6& covariance) const {
  const Eigen::Vector2d ratio =
      squared_innovation_.cwiseQuotient(expected_innovation_.cwiseMax(kLeastInnovation));
  const Vector6d scale = per_axis((kReportedFraction * ratio).cwiseSqrt());
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

bool SweepSmoother::is_smoothed(const MotionFilter& filter) const {
  return deviations_ && filter.previous_match();
}

MotionAtStamp SweepSmoother::motion_at(double seconds, const MotionFilter& filter,
                                       double duration) const {
  const MotionState& match = filter.state();
  if (!is_smoothed(filter)) {
    return {steadily_accelerated(match, filter.acceleration(), duration, seconds),
            filter.acceleration(), usual_covariance_};
  }
  const double half = 0.5 * duration;
  const double u = seconds / half;
  const Pose straight = moved(Pose::Identity(), match.twist, seconds);
  const Matrix6d from_middle = adjoint(straight.inverse());
  MotionAtStamp motion;
  motion.state.T_map_sensor =
      perturbed(match.T_map_sensor, deviations_->combined(parabola_at(u))) * straight;
  motion.state.twist =
      match.twist + from_middle * deviations_->combined({u - 0.5, -2.0 * u, u + 0.5}) / half;
  motion.acceleration = from_middle * deviations_->combined({1.0, -2.0, 1.0}) / (half * half);
  motion.covariance = from_middle *
                      scaled(deviations_->covariance_of(parabola_at(u) - kMiddleAlone)) *
                      from_middle.transpose();
  return motion;
}

}  // namespace lidar_mapping::front_end
