// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/input_validator.hpp"

#include "sensor_record.hpp"
#include "sweep_seam.hpp"
#include "time_offset.hpp"

namespace lidar_mapping::preprocessing {

using ImuRecord = SensorRecord<ImuSample>;
using VelocityRecord = SensorRecord<VelocitySample>;

struct PointsRecord {
  TopicStatistics topic;
  CloudSummary cloud;  ///< the last with points
  SweepSeam seam;
  std::vector<double> delays;  ///< s from the stamps to the deliveries
};

struct GnssRecord {
  TopicStatistics topic;
  SensorRecord<GnssFix> usable;
  std::map<std::string, std::size_t> rejected;  ///< how often, for what
  bool covariance_known = true;
};

// What the sensors sent, in a line each, and what is wrong with it. Offsets and units are found by
// comparison with the velocity, where there is one.

InputReport check(const PointsRecord& points, const ExtrinsicLookup& lookup,
                  const PreprocessingConfig& config);
InputReport check(const ImuRecord& imu, const VelocityRecord& velocity,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config);
InputReport check(const VelocityRecord& velocity, const GnssRecord& gnss,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config);
InputReport check(const GnssRecord& gnss, const ImuRecord& imu, const VelocityRecord& velocity,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config);

/// How many times the speeds of the fixes the measured ones are; nothing where too little moved.
std::optional<double> speed_scale(const VelocityRecord& velocity, const GnssRecord& gnss,
                                  const PreprocessingConfig& config);

/// A fault if the offset is large and well known; `parameter` takes it away.
void check_offset(const std::optional<TimeOffset>& offset, const std::string& parameter,
                  InputReport& report);

}  // namespace lidar_mapping::preprocessing
