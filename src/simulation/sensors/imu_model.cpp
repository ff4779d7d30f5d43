// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/imu_model.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Without errors, for tests.
ImuModel ideal() { return {{}, {}, 0.0}; }

/// A calibrated unit with its own attitude filter.
ImuModel good() {
  ImuModel model;
  model.orientation_noise = kOrientationNoise;
  model.gyro.noise = kGyroNoise;
  model.gyro.bias = kGyroBias;
  model.accelerometer.noise = kAccelerometerNoise;
  model.accelerometer.bias = kAccelerometerBias;
  return model;
}

/// As in telephones and inside LiDARs, uncalibrated. Values of their data sheets: 0.015 degrees/s
/// and 230 micro-g per square root of Hz, biases of 1 degree/s and 30 milli-g.
ImuModel consumer() {
  ImuModel model;
  model.gyro.noise_density = 2.6e-4;
  model.gyro.bias = 0.017;
  model.gyro.bias_walk = 1e-4;
  model.gyro.scale = 0.01;
  model.gyro.misalignment = 0.01;
  model.gyro.range = 34.9;
  model.accelerometer.noise_density = 2.3e-3;
  model.accelerometer.bias = 0.3;
  model.accelerometer.bias_walk = 1e-3;
  model.accelerometer.scale = 0.005;
  model.accelerometer.misalignment = 0.01;
  model.accelerometer.range = 4.0 * kGravity;
  return model;
}

}  // namespace

ImuModel imu_model(const std::string& name) {
  if (name == "good") return good();
  if (name == "consumer") return consumer();
  if (name == "ideal") return ideal();
  throw ConfigError("imu: '" + name + "' is unknown; use good, consumer or ideal");
}

std::vector<std::string> imu_names() { return {"good", "consumer", "ideal"}; }

}  // namespace lidar_mapping::simulation
