// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/covariance.hpp"

#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// How far a sweep deviates from the motion with the twist of its match: at begin, middle and end,
/// m and rad in the axes of the middle.
struct SweepDeviations {
  Eigen::Matrix<double, 18, 1> poses;
  Eigen::Matrix<double, 18, 18> covariance;

  /// The sum of the three with these weights.
  Vector6d combined(const Eigen::Vector3d& weights) const;
  /// Covariance of such a sum.
  Covariance6 covariance_of(const Eigen::Vector3d& weights) const;
};

/// Kalman filter of the deviation d(s) of a sweep from its match, s seconds after the middle, in
/// the axes there: T(s) = T_middle exp(d(s)) exp(s twist). The acceleration of d is white noise
/// about a mean (Barfoot, Tong, Särkkä 2014). The deviations at begin and middle stay in the state,
/// so that what is measured later improves them too (fixed-point smoother).
class DeviationFilter {
 public:
  /// `noise`: power spectral density of the acceleration per axis, m^2/s^3 and rad^2/s^3.
  DeviationFilter(const Vector6d& noise, const Vector6d& mean_acceleration)
      : noise_(noise), mean_acceleration_(mean_acceleration) {}

  /// Begins `seconds` before the middle with a deviation and its change per second.
  void begin(double seconds, const Vector12d& state, const Matrix12d& covariance);
  /// Moves on to `seconds` after the middle; back is not possible.
  void predict(double seconds);
  /// Takes the normal equations of the points of a time slice, multiplied by `weight`.
  void measure(const NdtPart& part, double weight);

  /// Deviation and its change per second now.
  Vector12d state() const { return x_.head<12>(); }
  Matrix12d covariance() const { return P_.topLeftCorner<12, 12>(); }
  /// To be called at the end of the sweep.
  SweepDeviations deviations() const;

 private:
  // Layout of the state, by definition: d, its change per second, d at the begin and in the middle,
  // six numbers each.
  static constexpr int kDimension = 24;
  static constexpr int kBegin = 12;   ///< index of d at the begin
  static constexpr int kMiddle = 18;  ///< index of d in the middle

  void keep(int where);
  void advance(double seconds);

  Vector6d noise_;
  Vector6d mean_acceleration_;
  double seconds_ = 0.0;  ///< of the state, after the middle
  Eigen::Matrix<double, kDimension, 1> x_ = Eigen::Matrix<double, kDimension, 1>::Zero();
  Eigen::Matrix<double, kDimension, kDimension> P_ =
      Eigen::Matrix<double, kDimension, kDimension>::Zero();
};

}  // namespace lidar_mapping::front_end
