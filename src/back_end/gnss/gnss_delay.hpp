// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Estimates the delay of the stamps of GNSS by comparing all positions with odometry (AntennaFit):
/// for each segment alone, or for all segments together if one does not determine it. At constant
/// speed a delay looks like an antenna further back, so that the correction of the lever arm from
/// the same fit belongs to the delay.
void estimate_gnss_delays(DriveGraph& drive, const BackEndConfig& config);

/// Velocity (m/s) of the antenna at the time of a position, by odometry, in the base_link of its
/// key frame.
Eigen::Vector3d antenna_velocity(const DriveGraph& drive, const DriveGnss& gnss);

/// The position with the delay of its stamp: the lever arm is that at the time of the measurement,
/// and the covariance includes the uncertainty of the delay.
GnssPosition delay_corrected_position(const DriveGraph& drive, const DriveGnss& gnss);

}  // namespace lidar_mapping::back_end
