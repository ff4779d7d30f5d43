// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Finds by how much the stamps of GNSS are late, from all positions beside odometry: for each
/// segment by itself, or where it tells too little for all together (AntennaFit). At an even speed
/// a delay looks like an antenna farther back, so what the fit makes of its place goes with it.
void estimate_gnss_delays(DriveGraph& drive, const BackEndConfig& config);

/// Velocity (m/s) of the antenna when a position was measured, in base_link at its key frame, as
/// odometry has it.
Eigen::Vector3d antenna_velocity(const DriveGraph& drive, const DriveGnss& gnss);

/// The position as it is known with the delay of its stamp: the lever arm leads to where the
/// antenna was when the fix was measured, and the covariance has grown by what is not known of the
/// delay.
GnssPosition delay_corrected_position(const DriveGraph& drive, const DriveGnss& gnss);

}  // namespace lidar_mapping::back_end
