// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "local_map/elevation_calibration.hpp"

namespace lidar_mapping::front_end {

/// Estimates the angle by which two scans have to be rotated upwards so that they fit. `map` holds
/// the points of scan a in its axes, `points` are those of scan b in its own axes. The angle is
/// solved for together with the relative pose, starting from `T_a_b`. Returns nothing if the scans
/// do not determine the angle.
std::optional<ElevationEstimate> estimate_elevation(const SampledPoints& points,
                                                    GaussianVoxelMap& map, const Pose& T_a_b);

}  // namespace lidar_mapping::front_end
