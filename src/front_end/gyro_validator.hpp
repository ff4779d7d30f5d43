// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "lidar_mapping/front_end/motion_prior.hpp"

#include "motion_filter.hpp"

namespace lidar_mapping::front_end {

/// What the mean rates of a gyro during the sweeps are worth, learnt from the matches: its bias,
/// and how far off it is. One that foretells the matches worse than they foretell each other counts
/// for nothing, and so does a rate far beyond all that it was right about so far.
class GyroValidator {
 public:
  /// Whether the gyro may have its say in this scan: it is not distrusted, and what it says of the
  /// mean rate and of the rest of the turning is not far beyond what it was right about.
  bool accepts(const MotionPrior& prior) const;
  /// A sweep of `duration` seconds, `seconds` after the one before, and its mean rate (rad/s, axes
  /// of base_link).
  void add(const MotionPrior& prior, double seconds, double duration);
  /// The turning from the sweep before to this one; nothing where sweeps or rates are missing or
  /// the gyro has not deserved it.
  std::optional<MeasuredTurning> turning() const;
  /// What a filter that turning() was given to may still be told.
  MotionPrior remaining_prior(MotionPrior prior) const;
  /// Takes in the attitude of the sweep before, the one expected without a gyro, and the matched
  /// one.
  void update(const Eigen::Quaterniond& previous, const Eigen::Quaterniond& without_gyro,
              const Eigen::Quaterniond& matched);
  /// It was looked at for long enough and found wrong.
  bool is_distrusted() const;

 private:
  double sigma() const;

  std::optional<Eigen::Vector3d> rate_;     ///< of this sweep, as measured
  std::optional<Eigen::Vector3d> between_;  ///< mean since the sweep before, as measured
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  double seconds_ = 0.0;
  int matches_ = 0;
  bool accepted_ = true;                ///< in this sweep
  double confirmed_rate_ = 0.0;         ///< the largest turning that it was right about, rad/s
  double gyro_variance_ = 0.0;          ///< running mean of its squared errors per axis, (rad/s)^2
  double variance_without_gyro_ = 0.0;  ///< and of the predictions without it
};

}  // namespace lidar_mapping::front_end
