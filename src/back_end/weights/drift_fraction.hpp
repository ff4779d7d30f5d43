// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "factors/drive_factors.hpp"

namespace lidar_mapping::back_end {

/// Standard deviation of the used positions about the solution, relative to their covariances; at
/// most 1.
double position_scatter(const DriveFactors& factors, const std::vector<bool>& used);

/// The fraction of the configured drift (standard deviations) that the odometry shows when it is
/// compared with positions. `factors` holds the solution with the full drift; `drive` has the scale
/// error already. Only the ratio of both errors counts: if the positions scatter by a tenth of
/// their covariances, a tenth of the drift gives a fraction of 1. All entries are 1 if too few key
/// frames have positions.
Vector6d observed_drift_fraction(const DriveGraph& drive, const BackEndConfig& config,
                                 const DriveFactors& factors, const std::vector<bool>& used);

}  // namespace lidar_mapping::back_end
