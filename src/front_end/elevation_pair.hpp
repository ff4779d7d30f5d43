// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "elevation_calibration.hpp"

namespace lidar_mapping::front_end {

/// The angle by which two scans are to be turned upwards so that they fit: `map` holds the points
/// of scan a in its axes, `points` are those of scan b in its own. Solved for together with the
/// relative pose, from `T_a_b` on. None where the scans do not say.
std::optional<ElevationEstimate> estimate_elevation(const SampledPoints& points,
                                                    registration::GaussianVoxelMap& map,
                                                    const Pose& T_a_b);

}  // namespace lidar_mapping::front_end
