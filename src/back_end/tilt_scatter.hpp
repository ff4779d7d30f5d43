// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Standard deviation (deg) of the tilt that the IMU's orientation gives at one key frame, such
/// that many may be weighed as if they were independent: from how the vertical wanders in
/// odometry's frame, at most imu_orientation_stddev_deg and no less than a quarter of it. Errors
/// that neighbours share count as often as they do, and odometry's own drift is counted as the
/// IMU's. As configured where neither loops nor positions hold the map, or where the vehicle
/// hardly turns.
double tilt_stddev_deg(const DriveGraph& drive, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
