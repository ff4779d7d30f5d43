// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>

#include "lidar_mapping/preprocessing/input_validator.hpp"

#include "checks/sensor_record.hpp"
#include "motion/time_offset.hpp"
#include "points/sweep_seam.hpp"

namespace lidar_mapping::preprocessing {

using ImuRecord = SensorRecord<ImuSample>;
using VelocityRecord = SensorRecord<VelocitySample>;

struct PointsRecord {
  TopicStatistics topic;
  CloudSummary cloud;  ///< the last cloud with points
  SweepSeam seam;
  std::size_t empty = 0;            ///< clouds without points
  std::size_t timed = 0;            ///< clouds with times
  std::size_t of_other_clock = 0;   ///< clouds with times that do not count from the stamp
  std::size_t damaged_packets = 0;  ///< of a sensor whose packets are decoded here
};

/// Refused fixes with the same kind of problem.
struct RefusedFixes {
  std::size_t count = 0;
  std::string problem;  ///< of the first one
};

struct GnssRecord {
  TopicStatistics topic;
  SensorRecord<GnssFix> usable;
  std::map<std::string, RefusedFixes> refused;  ///< by the kind of their problem
  bool covariance_known = true;
};

// Each check returns a line about the data of its sensor, and their problems. Time offsets and
// units are found by comparison with the velocity, if there is one.

InputReport check(const PointsRecord& points, const ExtrinsicLookup& lookup,
                  const PreprocessingConfig& config);
InputReport check(const ImuRecord& imu, const VelocityRecord& velocity,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config);
InputReport check(const VelocityRecord& velocity, const GnssRecord& gnss,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config);
InputReport check(const GnssRecord& gnss, const ImuRecord& imu, const VelocityRecord& velocity,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config);

/// Adds a fault if the points of a cloud lie where no LiDAR can have seen them.
void check_extent(const CloudExtent& extent, InputReport& report);

/// Adds a fault if the stamps of a sensor and of the points are of clocks that are far apart, by
/// the times when both were delivered. `parameter` and `configured` are those of check_offset().
void check_clock(const TopicStatistics& sensor, const TopicStatistics& points,
                 const std::string& parameter, double configured, InputReport& report);

/// True if the path of the fixes bends to the left where the gyro turns to the right, as that of
/// fixes whose latitude and longitude are swapped.
bool fixes_are_mirrored(const GnssRecord& gnss, const ImuRecord& imu, const ExtrinsicLookup& lookup,
                        const PreprocessingConfig& config);

/// Adds a fault if a velocity has another sign or unit than the accelerations that the IMU feels
/// ahead.
void check_accelerations(const VelocityRecord& velocity, const ImuRecord& imu,
                         const ExtrinsicLookup& lookup, const PreprocessingConfig& config,
                         InputReport& report);

/// Ratio of the measured speeds to the speeds of the fixes; empty if the vehicle moved too little.
std::optional<double> speed_scale(const VelocityRecord& velocity, const GnssRecord& gnss,
                                  const PreprocessingConfig& config);

/// Adds a fault if the offset is large and significant. `parameter` is the parameter that corrects
/// it; the stamps were moved by its present value `configured` (s) before they were compared.
void check_offset(const std::optional<TimeOffset>& offset, const std::string& parameter,
                  double configured, InputReport& report);

}  // namespace lidar_mapping::preprocessing
