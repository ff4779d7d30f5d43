// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "lidar_mapping/front_end/motion_prior.hpp"

#include "motion/motion_filter.hpp"

namespace lidar_mapping::front_end {

/// Lower bound of the standard deviation of a gyro's rate, rad/s: scale and axes of cheap gyros
/// have errors of 1 % each, which is this value at 1.4 rad/s. Tried: with 0.002 the gyro rotates
/// the map away from the points, and a person on stairs has twice the error.
constexpr double kLeastGyroSigma = 0.02;

/// Checks the mean rates of a gyro during the sweeps against the matches: learns the gyro's bias
/// and its error. A gyro that predicts the matches worse than a prediction without it is not used,
/// and neither is a rate far beyond all rates that were confirmed.
class GyroValidator {
 public:
  /// Whether the gyro is used for this scan: it is not distrusted, and its mean rate and its
  /// non-uniform rotation are not far beyond the confirmed rates.
  bool accepts(const MotionPrior& prior) const;
  /// Adds a sweep of `duration` seconds, `seconds` after the previous one, with its mean rate
  /// (rad/s, the LiDAR's axes).
  void add(const MotionPrior& prior, double seconds, double duration);
  /// The rotation from the previous sweep to this one. Empty if sweeps or rates are missing, or if
  /// the gyro is not accepted.
  std::optional<MeasuredTurning> turning() const;
  /// The prior without the parts that a filter has already received by turning().
  MotionPrior remaining_prior(MotionPrior prior) const;
  /// Learns from a match: attitude of the previous sweep, attitude predicted without the gyro, and
  /// matched attitude.
  void update(const Eigen::Quaterniond& previous, const Eigen::Quaterniond& without_gyro,
              const Eigen::Quaterniond& matched);
  /// The rate of this sweep without the bias, if there is one.
  std::optional<Eigen::Vector3d> rate() const;
  /// Adds how far the time slices of a sweep contradict the rate, see
  /// SweepSmoother::contradiction_to().
  void add_contradiction(double contradiction);
  /// True if the gyro was observed long enough and found wrong.
  bool is_distrusted() const;

 private:
  double sigma() const;

  std::optional<Eigen::Vector3d> rate_;     ///< rate of this sweep, as measured
  std::optional<Eigen::Vector3d> between_;  ///< mean rate since the previous sweep, as measured
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  double seconds_ = 0.0;
  int matches_ = 0;
  bool uniform_ = true;          ///< whether this sweep turns uniformly
  bool accepted_ = true;         ///< whether the gyro is accepted for this sweep
  double confirmed_rate_ = 0.0;  ///< the largest rate that the matches confirmed, rad/s
  double contradiction_ = 0.0;   ///< running mean
  double gyro_variance_ = 0.0;   ///< running mean of the gyro's squared errors per axis, (rad/s)^2
  double variance_without_gyro_ = 0.0;  ///< the same for predictions without the gyro
};

}  // namespace lidar_mapping::front_end
