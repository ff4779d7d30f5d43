// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive_factors.hpp"

namespace lidar_mapping::back_end {

/// Errors that all constraints of a kind share.
struct SystematicErrors {
  double scale_error = 0.0;  ///< share by which odometry's way has to be lengthened
  /// To add where a delay of GNSS is corrected: to the delay (s), and to what is made of the
  /// antenna's place (m, in base_link), which looks like a delay at an even speed.
  double delay = 0.0;
  Eigen::Vector2d lever_arm = Eigen::Vector2d::Zero();
};

/// Finds them beside the poses: a step of Newton's from the states that `factors` has, near a
/// minimum over the poses alone, to that over both. `used` marks the constraints that are believed;
/// `scatter` is by how much positions scatter beside what their covariances say (drift_share.hpp).
SystematicErrors estimate_systematic_errors(const DriveGraph& drive, const DriveFactors& factors,
                                            const std::vector<bool>& used, double scatter);

}  // namespace lidar_mapping::back_end
