// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::simulation {

// Standard deviations per sample and axis, chosen as of a good MEMS unit with its own attitude
// filter. Biases are drawn once per drive.
constexpr double kGyroNoise = 0.002;          ///< Noise of rates, rad/s.
constexpr double kGyroBias = 0.001;           ///< Bias of rates, rad/s.
constexpr double kAccelerometerNoise = 0.03;  ///< Noise of accelerations, m/s^2.
constexpr double kAccelerometerBias = 0.04;   ///< Bias of accelerations, m/s^2.
constexpr double kOrientationNoise = 0.001;   ///< Noise of the orientation, rad.
constexpr double kVelocityNoise = 0.02;       ///< Noise of the velocity, m/s.
/// Gravity along -z of the map frame in these worlds, m/s^2. Rounded, unlike kStandardGravity: the
/// results on record were measured with it, and true gravity differs from the standard by as much.
constexpr double kGravity = 9.81;

}  // namespace lidar_mapping::simulation
