// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::simulation {

/// A fault of an IMU.
struct ImuFault {
  /// Kinds of faults.
  enum class Kind {
    kVibration,  ///< Vibration by motors of `amount` m/s^2 (root mean square) on each axis.
    kScale,      ///< Rates and accelerations are too large by the fraction `amount`.
    /// Axis `amount` always measures 0: 0 to 2 of the gyroscope, 3 to 5 of the accelerometer.
    kAxis,
    kClip,    ///< Accelerations saturate at `amount` g and rates at `other` rad/s.
    kFrame,   ///< The sensor is rotated by 90 degrees about z against its transform.
    kUnits,   ///< Accelerations are in g (0) or rates in degrees/s (1).
    kOffset,  ///< Stamps are `amount` seconds late.
    kGap      ///< Every `other` seconds the samples of `amount` seconds are missing.
  };
  Kind kind = Kind::kScale;  ///< Kind of the fault.
  double amount = 0.0;       ///< Size of the fault; see Kind.
  double other = 0.0;        ///< Second value of the fault; see Kind.
};

/// Reads "imu_vibration=5", "imu_scale=0.05", "imu_axis=gz", "imu_clip=3" or "imu_clip=3,5",
/// "imu_frame", "imu_units=g" or "imu_units=degrees", "imu_offset=0.02", "imu_gap=2,20". Throws
/// ConfigError for any other name, and for a value that is missing or out of range.
ImuFault parse_imu_fault(const std::string& text);
/// How all faults are written, with the ranges of their values.
std::vector<std::string> imu_fault_formats();

/// Applies faults to the samples of a drive that begins at `begin`. They are applied in the order
/// of Kind, whatever their order in `faults`.
void corrupt(std::vector<ImuSample>& samples, const std::vector<ImuFault>& faults, Stamp begin,
             std::uint64_t seed);

}  // namespace lidar_mapping::simulation
