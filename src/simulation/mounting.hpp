#pragma once

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {

/// On a car: LiDAR and antenna on the roof, IMU in the boot; nothing quite straight. base_link is
/// on the ground under the rear axle.
SensorMounting car_mounting();

}  // namespace lidar_mapping::simulation
