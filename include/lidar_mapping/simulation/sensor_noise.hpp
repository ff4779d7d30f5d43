// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::simulation {

// Standard deviations per sample and axis: a MEMS unit of the better kind with its own attitude
// filter. Biases are drawn once per drive.
constexpr double kGyroNoise = 0.002;          ///< rad/s
constexpr double kGyroBias = 0.001;           ///< rad/s
constexpr double kAccelerometerNoise = 0.03;  ///< m/s^2
constexpr double kAccelerometerBias = 0.04;   ///< m/s^2
constexpr double kOrientationNoise = 0.001;   ///< rad
constexpr double kVelocityNoise = 0.02;       ///< m/s
constexpr double kGravity = 9.81;             ///< m/s^2, along -z of map, in these worlds

}  // namespace lidar_mapping::simulation
