// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// The sample at `stamp` between a and b: linear, orientations on the shorter great circle (slerp).
/// There is an orientation only where both have one. `stamp` lies within [a.stamp, b.stamp].
ImuSample interpolated(const ImuSample& a, const ImuSample& b, Stamp stamp);
VelocitySample interpolated(const VelocitySample& a, const VelocitySample& b, Stamp stamp);

/// The same value with the axes turned and the origin moved from a sensor to base_link. A velocity
/// is that of the other origin (v_base = R v - omega x r, omega = R omega_sensor).
ImuSample in_base(const ImuSample& sample, const Pose& T_base_sensor);
VelocitySample in_base(const VelocitySample& sample, const Pose& T_base_sensor);

/// rad/s: nobody maps while turning twice a second; in degrees/s it is a usual turn.
constexpr double kMaxVehicleTurnRate = 12.0;

/// Finite, and no faster than anything that carries a LiDAR.
bool is_plausible(const ImuSample& sample);
bool is_plausible(const VelocitySample& sample);

}  // namespace lidar_mapping::preprocessing
