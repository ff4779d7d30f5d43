// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "twist_forecast.hpp"

namespace lidar_mapping::front_end {

using registration::Matrix12d;
using registration::MotionState;
using registration::Vector12d;

/// The pose after moving for `seconds` with a constant twist (own axes, m/s and rad/s).
Pose moved(const Pose& T, const Vector6d& twist, double seconds);

/// The motion `seconds` after a reference time, the middle of a sweep of `duration` seconds. There
/// `state` is where a sweep fits if its twist is taken to be constant; but it changes by
/// `acceleration` per second.
MotionState steadily_accelerated(const MotionState& state, const Vector6d& acceleration,
                                 double duration, double seconds);

/// The constant twist that leads from a to b in `seconds`; inverse of moved().
Vector6d twist_between(const Pose& a, const Pose& b, double seconds);

/// Covariance of that pose, for a covariance of the pose and the twist now.
Covariance6 pose_covariance(const Matrix12d& covariance, const Vector6d& twist, double seconds);

/// How the sensor turned, rad/s in its own axes.
struct MeasuredTurning {
  Eigen::Vector3d between;  ///< on the way from the state before, in the mean
  Eigen::Vector3d within;   ///< during the sweep
  double sigma = 0.0;       ///< of both, per axis
};

/// Pose and twist of the sensor with their covariance, for perturbed(MotionState, Vector12d). The
/// twist goes on as forecast (TwistForecast) but for an unknown constant acceleration. How large
/// that may be follows the drive: a vehicle at rest or on a straight road is held more firmly than
/// one that is carried around a corner.
class MotionFilter {
 public:
  /// The largest standard deviations of the acceleration (m/s^2) and the angular one (rad/s^2).
  MotionFilter(double acceleration_sigma, double angular_acceleration_sigma);

  /// At rest in all that is known, the twist unknown to `speed_sigma` and `rate_sigma`.
  void reset(const Pose& pose, double speed_sigma, double rate_sigma);
  /// Goes on from this state. How large accelerations are stays known.
  void restart(const MotionState& state, const Matrix12d& covariance);
  /// Moves the state on by `seconds`, or back if they are negative.
  void predict(double seconds) { predict(seconds, std::nullopt); }
  /// Where the turning is measured, it is that, and not what was forecast of it.
  void predict(double seconds, const std::optional<MeasuredTurning>& turning);
  /// As predicted last, but without measurements of the turning.
  const MotionState& forecast_state() const { return forecast_state_; }
  /// The same filter before a motion unlike all of late.
  MotionFilter with_high_process_noise() const;
  /// Take measurements of the twist in, with the standard deviation of each axis.
  void measure_rate(const Eigen::Vector3d& angular_velocity, double sigma);
  void measure_velocity(const Eigen::Vector3d& linear_velocity, double sigma);
  /// Only the component along a unit vector in the sensor's axes is measured.
  void measure_velocity_along(const Eigen::Vector3d& direction, double speed, double sigma);
  /// Takes in where the sensor is along its own x and y, to `sigma` (m), and which way it looks
  /// about its z, to `angle_sigma` (rad).
  void measure_planar_pose(const Pose& pose, double sigma, double angle_sigma);
  /// Lets the twist fall exponentially: nobody has seen it lately.
  void slow_down(double seconds, double time_constant);
  /// Replaces the predicted state by a matched one, and learns how far off the prediction was. Of
  /// the translation only what `observed` (a projection, the sensor's axes) lets through teaches
  /// anything: along other directions the match is the prediction.
  void correct(const MotionState& state, const Matrix12d& covariance,
               const Eigen::Matrix3d& observed = Eigen::Matrix3d::Identity());

  /// The map grew at this pose. Along directions in which the pose was only predicted, the new part
  /// of the map shares its error: against it the pose is known.
  void anchor(const std::vector<Eigen::Vector3d>& directions);

  /// Covariance of the pose `seconds` before or after the state, beside what is known of the state:
  /// the twist is not as constant as it is taken to be.
  Covariance6 acceleration_covariance(double seconds) const;

  const MotionState& state() const { return state_; }
  /// How the twist changed on the way to the state that was matched last, per second; zero where
  /// none was matched since the last prediction.
  const Vector6d& acceleration() const { return acceleration_; }
  const Matrix12d& covariance() const { return covariance_; }
  registration::MotionBelief belief() const;

 private:
  void apply_forecast(double seconds);
  void apply_turning(const MeasuredTurning& turning);
  Vector6d plausible_acceleration(const Vector6d& acceleration,
                                  const Eigen::Matrix3d& observed) const;
  void update_acceleration_sigmas(const MotionState& state, const Eigen::Matrix3d& observed);
  void measure(const Vector12d& row, double innovation, double sigma);

  /// Standard deviation of an acceleration, between limits.
  struct AccelerationSigma {
    double max_sigma;
    double sigma;

    void update(double acceleration);
  };
  AccelerationSigma linear_;
  AccelerationSigma angular_;
  double step_seconds_ = 0.0;  ///< of the last prediction
  TwistForecast forecast_;
  Pose T_map_corrected_;          ///< the pose that was last corrected
  double since_corrected_ = 0.0;  ///< s
  bool corrected_ = false;        ///< and not moved on since then
  Vector6d acceleration_ = Vector6d::Zero();
  MotionState state_;
  MotionState forecast_state_;
  bool turning_measured_ = false;  ///< on the way to the state
  Matrix12d covariance_ = Matrix12d::Identity();
};

}  // namespace lidar_mapping::front_end
