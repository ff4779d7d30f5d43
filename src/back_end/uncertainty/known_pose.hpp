// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/covariance.hpp"

namespace lidar_mapping::back_end {

/// Information of a key frame that is taken as known: standard deviations of one micrometre and two
/// microradians. Chosen: these are two centimetres after ten kilometres, below the errors of a
/// drive.
constexpr double kKnownInformation = 1e12;

/// A covariance by the tangent of the graph, which has half angles, as one of poses (m, rad).
inline Covariance6 of_whole_angles(const Matrix6d& of_tangent) {
  const Vector6d angles = (Vector6d() << 1.0, 1.0, 1.0, 2.0, 2.0, 2.0).finished();
  return angles.asDiagonal() * of_tangent * angles.asDiagonal();
}

}  // namespace lidar_mapping::back_end
