// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

namespace lidar_mapping::registration {

/// The thinnest axis of the Gaussian, its length the inverse of the plane's thickness (1/m) after
/// the weak prior of the model; shorter or zero where the points lie on a line, because then the
/// axis is arbitrary around it. As far as rings crossed the voxel one by one (`ring_isolation`, 0
/// to 1) it is levelled where the points are no plane.
Eigen::Vector3d weighted_normal(const Gaussian& gaussian, const PlaneModel& model,
                                double ring_isolation);

}  // namespace lidar_mapping::registration
