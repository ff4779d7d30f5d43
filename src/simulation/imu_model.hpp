// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace lidar_mapping::simulation {

/// Errors of a gyroscope (rad/s) or of an accelerometer (m/s^2), for each axis.
struct InertialErrors {
  double noise = 0.0;          ///< standard deviation of a sample
  double noise_density = 0.0;  ///< the same for any rate: its share is density * sqrt(rate)
  double bias = 0.0;           ///< standard deviation over drives
  double bias_walk = 0.0;      ///< standard deviation of its change after a second
  double scale = 0.0;          ///< standard deviation over drives, as a share
  double misalignment = 0.0;   ///< rad, standard deviation over drives
  double range = std::numeric_limits<double>::infinity();  ///< where it clips
};

struct ImuModel {
  std::string name;
  InertialErrors gyro;
  InertialErrors accelerometer;
  bool has_orientation = true;
  double orientation_noise = 0.0;  ///< rad
};

/// One of imu_names(). Throws ConfigError for any other name.
ImuModel imu_model(const std::string& name);

}  // namespace lidar_mapping::simulation
