// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {

/// A step with a larger error than this is wrong, whatever its covariance is. Chosen: a wall is
/// then double in the map, or leans by as much after 20 m.
constexpr double kWrongStep = 0.3;  ///< m
/// The same for the rotation: one degree.
constexpr double kWrongStepAngle = kRadPerDeg;  ///< rad

}  // namespace lidar_mapping::front_end
