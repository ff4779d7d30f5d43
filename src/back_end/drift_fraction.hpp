// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive_factors.hpp"

namespace lidar_mapping::back_end {

/// By how much the believed positions scatter beside what their covariances say, at most 1.
double position_scatter(const DriveFactors& factors, const std::vector<bool>& used);

/// What share of the configured drift (standard deviations) odometry shows beside positions, from a
/// solution with all of it, whose states `factors` has. `drive` has its stretch. Where positions
/// scatter by a tenth of their covariances, a tenth of the drift counts as all: what counts is
/// their ratio. All where too few key frames have positions.
Vector6d observed_drift_fraction(const DriveGraph& drive, const BackEndConfig& config,
                                 const DriveFactors& factors, const std::vector<bool>& used);

}  // namespace lidar_mapping::back_end
