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

/// The properties of a cloud that are checked.
struct CloudSummary {
  Stamp stamp = 0;
  std::string frame_id;  ///< as in the message
  std::size_t points = 0;
  std::string fields;
  std::string time_field;  ///< empty if there is none
  std::string time_unit;
  bool absolute_times = false;
  bool foreign_clock = false;
  double first_time = 0.0;  ///< s
  double last_time = 0.0;
  std::optional<double> delay;  ///< s from the stamp to the delivery, if known
  /// Points of the first and the last half percent of the scan's time, in the sensor's frame.
  std::vector<Eigen::Vector3f> begin_points, end_points;
};

/// Checks the data of the sensors before they are used for mapping: rates, frames, units, times,
/// gravity, fixes. It checks the messages as they arrive, not the output of preprocessing.
class InputValidator {
 public:
  explicit InputValidator(const PreprocessingConfig& config);
  ~InputValidator();

  void add_scan(const CloudSummary& cloud);
  void add_imu(const ImuSample& sample, const std::string& frame_id);
  void add_velocity(const VelocitySample& sample, const std::string& frame_id);
  void add_gnss(const GnssFix& fix, const std::string& frame_id);

  /// Reports on points, imu, velocity and gnss, in this order. A missing input is a fault only if
  /// it is the points.
  std::vector<InputReport> report(const ExtrinsicLookup& lookup) const;

 private:
  struct Records;

  PreprocessingConfig config_;
  std::unique_ptr<Records> records_;
};

}  // namespace lidar_mapping::preprocessing
