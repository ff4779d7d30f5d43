// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::simulation {

/// One thing that is wrong with an IMU.
struct ImuFault {
  enum class Kind {
    kVibration,  ///< shaken by motors: `amount` m/s^2 (root mean square) on each axis
    kScale,      ///< rates and accelerations are too large by a share of `amount`
    kAxis,       ///< axis `amount` says 0 all the time: 0 to 2 of the gyroscope, 3 to 5 of the
                 ///< accelerometer
    kClip,       ///< accelerations end at `amount` g and rates at `other` rad/s
    kFrame,      ///< turned by 90 degrees about z against its transform
    kUnits,      ///< accelerations in g (0) or rates in degrees/s (1)
    kOffset,     ///< stamps are `amount` seconds late
    kGap         ///< every `other` seconds `amount` seconds of samples are missing
  };
  Kind kind = Kind::kScale;
  double amount = 0.0;
  double other = 0.0;
};

/// From "imu_vibration=5", "imu_scale=0.05", "imu_axis=gz", "imu_clip=3" or "imu_clip=3,5",
/// "imu_frame", "imu_units=g" or "imu_units=degrees", "imu_offset=0.02", "imu_gap=2,20".
/// Throws ConfigError for any other name, a missing amount or one out of range.
ImuFault parse_imu_fault(const std::string& text);
/// "imu_vibration" and so on.
std::vector<std::string> imu_fault_names();

/// Spoils the samples of a drive that begins at `begin`, in the order in which the kinds are
/// listed, whatever the order of the faults.
void spoil(std::vector<ImuSample>& samples, const std::vector<ImuFault>& faults, Stamp begin,
           std::uint64_t seed);

}  // namespace lidar_mapping::simulation
