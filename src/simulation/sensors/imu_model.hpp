// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <string>

namespace lidar_mapping::simulation {

/// Errors of a gyroscope (rad/s) or of an accelerometer (m/s^2), for each axis.
struct InertialErrors {
  double noise = 0.0;  ///< Standard deviation of a sample.
  /// Noise density, independent of the rate: adds density * sqrt(rate).
  double noise_density = 0.0;
  double bias = 0.0;          ///< Standard deviation of the bias over drives.
  double bias_walk = 0.0;     ///< Standard deviation of the change of the bias after a second.
  double scale = 0.0;         ///< Standard deviation of the scale error over drives.
  double misalignment = 0.0;  ///< Standard deviation of the misalignment over drives, rad.
  double range = std::numeric_limits<double>::infinity();  ///< Value at which it saturates.
};

/// Errors of an IMU.
struct ImuModel {
  InertialErrors gyro;
  InertialErrors accelerometer;
  /// Standard deviation of the orientation, rad; none: it gives no orientation.
  std::optional<double> orientation_noise;
};

/// Model of this name, one of imu_names(). Throws ConfigError for any other name.
ImuModel imu_model(const std::string& name);

}  // namespace lidar_mapping::simulation
