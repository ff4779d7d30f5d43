// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "factors/drive_factors.hpp"

namespace lidar_mapping::back_end {

/// Systematic errors, which all constraints of a kind have in common.
struct SystematicErrors {
  double scale_error = 0.0;  ///< relative scale error of odometry, as in OdometryErrors
  /// Corrections where a delay of GNSS is corrected: of the delay (s), and of the lever arm (m, in
  /// base_link), which looks like a delay at constant speed.
  double delay = 0.0;
  Eigen::Vector2d lever_arm = Eigen::Vector2d::Zero();
};

/// Estimates the systematic errors together with the poses. The states of `factors` are near the
/// minimum over the poses; one Newton step leads to the minimum over both. `used` selects the
/// constraints; `scatter` is that of position_scatter() (drift_fraction.hpp).
SystematicErrors estimate_systematic_errors(const DriveGraph& drive, const DriveFactors& factors,
                                            const std::vector<bool>& used, double scatter);

}  // namespace lidar_mapping::back_end
