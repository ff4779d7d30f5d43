// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "lidar_mapping/registration/registration.hpp"

namespace lidar_mapping::registration {

/// The NDT of this package for two single clouds: point to plane of a voxel, with coarser voxels
/// where the finest do not find a good match.
std::unique_ptr<Registration> make_ndt(const RegistrationConfig& config);
/// VGICP (Koide et al. 2021): planes of the source's points against planes of the target's voxels.
std::unique_ptr<Registration> make_vgicp(const RegistrationConfig& config);

}  // namespace lidar_mapping::registration
