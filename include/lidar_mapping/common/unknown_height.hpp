// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace lidar_mapping {

/// [m] Standard deviation that stands for a height which was not measured: no number may be NaN in
/// messages and files, and with that one the height has no weight anywhere. Far more than any
/// receiver's error, and its square still has all digits beside others.
constexpr double kUnknownHeightStddev = 1e4;

/// Whether a position with this covariance (m^2, East-North-Up) has a height.
inline bool has_height(const Eigen::Matrix3d& covariance) {
  return covariance(2, 2) < kUnknownHeightStddev * kUnknownHeightStddev;
}

}  // namespace lidar_mapping
