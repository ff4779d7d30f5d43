// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/imu_model.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

namespace lidar_mapping::simulation {

namespace {

struct NamedImu {
  const char* name;
  ImuModel model;
};

// The columns of a sensor: noise, noise_density, bias, bias_walk, scale, misalignment, range.
const NamedImu kModels[] = {
    // A calibrated unit with its own attitude filter.
    {"good",
     {{kGyroNoise, 0.0, kGyroBias},
      {kAccelerometerNoise, 0.0, kAccelerometerBias},
      kOrientationNoise}},
    // As in telephones and inside LiDARs, uncalibrated. Values of their data sheets: 0.015
    // degrees/s and 230 micro-g per square root of Hz, biases of 1 degree/s and 30 milli-g.
    {"consumer",
     {{0.0, 2.6e-4, 0.017, 1e-4, 0.01, 0.01, 34.9},
      {0.0, 2.3e-3, 0.3, 1e-3, 0.005, 0.01, 4.0 * kGravity},
      {}}},
    // Without errors, for tests.
    {"ideal", {{}, {}, 0.0}}};

}  // namespace

ImuModel imu_model(const std::string& name) {
  for (const NamedImu& known : kModels) {
    if (name == known.name) return known.model;
  }
  throw ConfigError("imu: '" + name + "' is unknown; use good, consumer or ideal");
}

std::vector<std::string> imu_names() {
  std::vector<std::string> names;
  for (const NamedImu& known : kModels) names.emplace_back(known.name);
  return names;
}

}  // namespace lidar_mapping::simulation
