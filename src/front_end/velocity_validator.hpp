// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace lidar_mapping::front_end {

/// What a measured velocity (wheels, radar) is worth, learnt from the matches that observed the
/// motion themselves: its scale, and how far it is off. A velocity with a wrong scale is corrected,
/// one that is always zero soon counts for nothing.
class VelocityValidator {
 public:
  /// Takes in a pair; both m/s in the same axes.
  void update(const Eigen::Vector3d& measured, const Eigen::Vector3d& true_velocity);

  Eigen::Vector3d corrected(const Eigen::Vector3d& measured) const { return scale() * measured; }
  /// Standard deviation per axis (m/s) of a corrected velocity that may have gone wrong just now,
  double cautious_sigma(double speed) const;
  /// and of one that is as good as it has been.
  double usual_sigma() const;

 private:
  double scale() const;

  double product_ = 0.0;    ///< of measured and true velocities
  double square_ = 0.0;     ///< of measured ones
  double peak_ = 0.0;       ///< largest recent error, m/s
  double variance_ = -1.0;  ///< running mean of squared errors per axis; negative: none yet
};

}  // namespace lidar_mapping::front_end
