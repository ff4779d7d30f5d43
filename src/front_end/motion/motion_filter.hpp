// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"

#include "matching/ndt_types.hpp"
#include "motion/twist_predictor.hpp"

namespace lidar_mapping::front_end {

/// The pose after moving for `seconds` with a constant twist (in its own axes, m/s and rad/s).
Pose moved(const Pose& T, const Vector6d& twist, double seconds);

/// The part of a time without observations for which a motion goes on, s.
double continued_time(double seconds);

/// The pose `seconds` later, or earlier if they are negative, if nothing was observed since: as
/// moved(), but the sensor tilts for a second only, and after continued_time() it stands. Stamps
/// may jump by years.
Pose continued(const Pose& T, const Vector6d& twist, double seconds);

/// The motion `seconds` after a reference time, which is the middle of a sweep of `duration`
/// seconds. `state` is the result of a match that takes the twist as constant during the sweep; in
/// truth it changes by `acceleration` per second.
MotionState steadily_accelerated(const MotionState& state, const Vector6d& acceleration,
                                 double duration, double seconds);

/// The constant twist that leads from a to b in `seconds`; inverse of moved().
Vector6d twist_between(const Pose& a, const Pose& b, double seconds);

/// Covariance of the pose that continued() gives, for a covariance of the pose and the twist now.
Covariance6 pose_covariance(const Matrix12d& covariance, const Vector6d& twist, double seconds);

/// The measured rotation of the sensor, rad/s in its own axes.
struct MeasuredTurning {
  Eigen::Vector3d between;  ///< mean rate since the previous state
  Eigen::Vector3d within;   ///< rate during the sweep
  double sigma = 0.0;       ///< standard deviation of both, per axis
  bool uniform = true;      ///< the sweep turns at that rate at every instant, not only in the mean
};

/// A match, seen from a later one or from the present state.
struct PreviousMatch {
  MotionState state;
  double seconds_before = 0.0;  ///< s from the match until then
};

/// Disagreement of two sweeps about the pose half-way between their middles: the previous one
/// continued forwards compared with the current one continued backwards, m and rad per axis. It is
/// zero if the twist is constant, and also if it changes steadily.
Vector6d gap_between(const PreviousMatch& previous, const MotionState& current);

/// Kalman filter of the sensor's pose and twist, for perturbed(MotionState, Vector12d). The twist
/// continues as TwistPredictor predicts, plus an unknown constant acceleration. The size of this
/// acceleration is learned from the drive: the state of a vehicle at rest or on a straight road is
/// predicted with a smaller covariance than that of a vehicle in a sharp bend.
class MotionFilter {
 public:
  /// Takes the largest standard deviations of the acceleration (m/s^2) and the angular acceleration
  /// (rad/s^2).
  MotionFilter(double acceleration_sigma, double angular_acceleration_sigma);

  /// Starts at rest; the twist is unknown with the standard deviations `speed_sigma` and
  /// `rate_sigma`.
  void reset(const Pose& pose, double speed_sigma, double rate_sigma);
  /// Continues from this state. The learned size of accelerations is kept.
  void restart(const MotionState& state, const Matrix12d& covariance);
  /// Predicts the state `seconds` later, or earlier if they are negative, see continued(). A
  /// measured rotation, if there is one, replaces the forecast of the rotation.
  void predict(double seconds, const std::optional<MeasuredTurning>& turning = std::nullopt);
  /// The last prediction, but without measured rotation.
  const MotionState& forecast_state() const { return forecast_state_; }
  /// The same filter with the largest accelerations: for a motion that differs from all recent
  /// ones.
  MotionFilter with_high_process_noise() const;
  /// Update with measurements of the twist; `sigma` is the standard deviation of each axis.
  void measure_rate(const Eigen::Vector3d& angular_velocity, double sigma);
  void measure_velocity(const Eigen::Vector3d& linear_velocity, double sigma);
  /// Update with the position along the sensor's own x and y, to `sigma` (m), and with the heading
  /// about its z, to `angle_sigma` (rad).
  void measure_planar_pose(const Pose& pose, double sigma, double angle_sigma);
  /// Reduces the twist exponentially, because it has not been observed lately.
  void slow_down(double seconds, double time_constant);
  /// Replaces the predicted state by a matched one, and learns from the error of the prediction.
  /// Only the translation that passes `observed` (a projection, in the sensor's axes) is used for
  /// learning: along other directions the match is equal to the prediction.
  void correct(const MotionState& state, const Matrix12d& covariance,
               const Eigen::Matrix3d& observed = Eigen::Matrix3d::Identity());

  /// To be called when a scan was inserted at this pose. Along directions in which the pose was
  /// only predicted, the new part of the map has the same error: relative to it the pose is known.
  void anchor(const std::vector<Eigen::Vector3d>& directions);

  const MotionState& state() const { return state_; }
  /// Change of the twist per second before the last matched state; zero if nothing was matched
  /// since the last prediction.
  const Vector6d& acceleration() const { return acceleration_; }
  /// The last match but one, with the time from it to the last one. Empty if nothing was matched
  /// since the last prediction, or only once since the start.
  const std::optional<PreviousMatch>& previous_match() const { return previous_match_; }
  /// The last match, with the time from it to the state. Empty if there was none since the start.
  std::optional<PreviousMatch> last_match() const;
  /// True if the rotation up to the state was measured at every instant, not only forecast.
  bool is_rotation_measured() const { return turning_measured_; }
  const Matrix12d& covariance() const { return covariance_; }
  MotionBelief belief() const;

 private:
  void apply_forecast(double seconds);
  void grow_covariance(double seconds, bool turning_measured);
  void apply_turning(const MeasuredTurning& turning);
  Vector6d plausible_acceleration(const Vector6d& acceleration,
                                  const Eigen::Matrix3d& observed) const;
  void update_acceleration_sigmas(const MotionState& state, const Eigen::Matrix3d& observed);
  void measure(const Vector12d& row, double innovation, double sigma);

  /// Standard deviation of an acceleration, between two bounds.
  struct AccelerationSigma {
    double max_sigma;
    double sigma;

    void update(double acceleration);
  };
  AccelerationSigma linear_;
  AccelerationSigma angular_;
  double step_seconds_ = 0.0;  ///< of the last prediction
  TwistPredictor forecast_;
  MotionState last_corrected_;    ///< the state that was last corrected
  bool has_match_ = false;        ///< true if that was a match, not the start
  double since_corrected_ = 0.0;  ///< s
  std::optional<PreviousMatch> previous_match_;
  bool corrected_ = false;  ///< true if nothing was predicted since then
  Vector6d acceleration_ = Vector6d::Zero();
  MotionState state_;
  MotionState forecast_state_;
  bool turning_measured_ = false;  ///< the rotation up to the state was measured
  Matrix12d covariance_ = Matrix12d::Identity();
};

}  // namespace lidar_mapping::front_end
