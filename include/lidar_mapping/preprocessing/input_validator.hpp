// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/check_diagnostic.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// What is told of a cloud.
struct CloudSummary {
  Stamp stamp = 0;
  std::string frame_id;  ///< as the message has it
  std::size_t points = 0;
  std::string fields;
  std::string time_field;  ///< empty if there is none
  std::string time_unit;
  bool absolute_times = false;
  bool foreign_clock = false;
  double first_time = 0.0;  ///< s
  double last_time = 0.0;
  std::optional<double> delay;  ///< s from the stamp to the delivery, where that is known
  /// Points of the first and the last half percent of the scan's time, in the sensor's frame.
  std::vector<Eigen::Vector3f> begin_points, end_points;
};

/// Looks at what sensors send before anybody maps with it: rates, frames, units, times, gravity,
/// fixes. It judges the messages as they come, not what preprocessing makes of them.
class InputValidator {
 public:
  explicit InputValidator(const PreprocessingConfig& config);
  ~InputValidator();

  void add_scan(const CloudSummary& cloud);
  void add_imu(const ImuSample& sample, const std::string& frame_id);
  void add_velocity(const VelocitySample& sample, const std::string& frame_id);
  void add_gnss(const GnssFix& fix, const std::string& frame_id);

  /// Points, imu, velocity, gnss. An input that never came is a fault of the points only.
  std::vector<InputReport> report(const ExtrinsicLookup& lookup) const;

 private:
  struct Records;

  PreprocessingConfig config_;
  std::unique_ptr<Records> records_;
};

}  // namespace lidar_mapping::preprocessing
