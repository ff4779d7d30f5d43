// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {

/// On a car: LiDAR and antenna on the roof, IMU in the boot, all slightly misaligned. base_link is
/// on the ground under the rear axle.
SensorMounting car_mounting();
/// Hand-held, with the LiDAR 0.3 m above base_link.
SensorMounting hand_held_mounting();
/// On the back of a legged robot; base_link is the middle of its body.
SensorMounting legged_mounting();
/// On a drone: LiDAR on top; base_link is the middle of its frame.
SensorMounting drone_mounting();

}  // namespace lidar_mapping::simulation
