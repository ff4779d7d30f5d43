// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Standard deviation (rad) of the tilt by the IMU's orientation at one key frame, so that many of
/// them can be weighted as if they were independent. It is estimated from the variation of the
/// vertical in odometry's frame, between a quarter of imu_orientation_stddev and the whole of
/// it. Errors that neighbours have in common are included, and the drift of odometry counts as an
/// error of the IMU. The configured value is used if neither loops nor positions constrain the map,
/// or if the vehicle hardly turns.
double tilt_stddev(const DriveGraph& drive, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
