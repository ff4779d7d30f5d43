// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// The sample at `stamp`, interpolated between a and b: linear, orientations on the shorter great
/// circle (slerp). There is an orientation only if both samples have one. `stamp` lies within
/// [a.stamp, b.stamp].
ImuSample interpolated(const ImuSample& a, const ImuSample& b, Stamp stamp);
VelocitySample interpolated(const VelocitySample& a, const VelocitySample& b, Stamp stamp);

/// Transforms a sample from the sensor's frame to base_link. The velocity is that of the origin of
/// base_link (v_base = R v - omega x r, omega = R omega_sensor).
ImuSample in_base(const ImuSample& sample, const Pose& T_base_sensor);
VelocitySample in_base(const VelocitySample& sample, const Pose& T_base_sensor);

/// rad/s. Chosen: no vehicle turns twice a second while mapping; in degrees/s this is a usual
/// value.
constexpr double kMaxVehicleTurnRate = 12.0;

/// True if the values are finite and possible for anything that carries a LiDAR.
bool is_plausible(const ImuSample& sample);
bool is_plausible(const VelocitySample& sample);

}  // namespace lidar_mapping::preprocessing
