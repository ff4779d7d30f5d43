// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace lidar_mapping::front_end {

/// Learns scale and accuracy of a measured velocity (wheels, radar) from the matches that observed
/// the motion themselves. A velocity with a wrong scale is corrected; a velocity that is always
/// zero, or has another unit or sign, soon gets no weight, and is distrusted.
class VelocityValidator {
 public:
  /// Adds a pair of velocities, both in m/s and in the same axes.
  void update(const Eigen::Vector3d& measured, const Eigen::Vector3d& true_velocity);

  Eigen::Vector3d corrected(const Eigen::Vector3d& measured) const { return scale() * measured; }
  /// Standard deviation per axis (m/s) of a corrected velocity, if it may have become wrong just
  /// now.
  double cautious_sigma(double speed) const;
  /// The same for a velocity that is as accurate as before.
  double usual_sigma() const;
  /// True if the velocity was compared for long enough and is off by half of the speed: it has
  /// another unit, sign or axis, or its sensor does not measure.
  bool is_distrusted() const;

 private:
  double scale() const;

  double product_ = 0.0;        ///< sum of products of measured and true velocities
  double square_ = 0.0;         ///< sum of squares of measured velocities
  double peak_ = 0.0;           ///< largest recent error, m/s
  double variance_ = -1.0;      ///< running mean of squared errors per axis; negative: none yet
  double squared_speed_ = 0.0;  ///< recent sum of squared true speeds, m^2/s^2
  double squared_error_ = 0.0;  ///< the same of the errors of what was measured
};

}  // namespace lidar_mapping::front_end
