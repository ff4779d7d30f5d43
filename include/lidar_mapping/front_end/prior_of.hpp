// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"

namespace lidar_mapping::front_end {

/// The prior from samples at the scan's stamp, in the axes of base_link; each may be missing. An
/// angular velocity of the velocity sample that is exactly zero was not measured. `fingerprint` is
/// that of the points as the driver sent them.
MotionPrior prior_of(const std::optional<ImuSample>& imu,
                     const std::optional<VelocitySample>& velocity,
                     std::optional<UnevenTurning> uneven_turning,
                     const std::optional<FeltForce>& felt,
                     std::optional<std::uint64_t> fingerprint);

}  // namespace lidar_mapping::front_end
