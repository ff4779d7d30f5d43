// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/check_diagnostic.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// Format of the message of a cloud.
struct CloudFormat {
  std::string fields;               ///< "x y z intensity ring time", in the message's order
  std::string contents;             ///< of a message without fields: "76 packets of a VLP-16"
  std::size_t damaged_packets = 0;  ///< of the contents, left out
  std::string intensity_field;      ///< empty if there is none
  std::string time_field;           ///< empty if there is none
  std::string time_unit;            ///< "s", "ms", "us" or "ns"; empty if there are no times
  bool absolute_times = false;      ///< times of the clock of the stamps
  bool foreign_clock = false;       ///< absolute by another clock: counted from the first point
  double first_time = 0.0;          ///< s, relative to the stamp or as the field counts
  double last_time = 0.0;           ///< s, as first_time
};

/// Where the points of a cloud lie, as a sample of them tells.
struct CloudExtent {
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< medians of x, y and z, m
  float radius = 0.0F;                               ///< median distance from the middle, m
};

/// The extent of the points that are finite and not at the sensor's origin; empty without any.
std::optional<CloudExtent> extent_of(const PointCloud& cloud);

/// The properties of a cloud that are checked.
struct CloudSummary : CloudFormat {
  Stamp stamp = 0;                    ///< of the message
  std::string frame_id;               ///< as in the message
  std::size_t points = 0;             ///< their number, also of those that are not finite
  std::optional<double> delay;        ///< s from the stamp to the delivery, if known
  std::optional<CloudExtent> extent;  ///< empty without points, or if their frame moves
  /// Points of the first 0.6 % of the scan's time, m, in the sensor's frame.
  std::vector<Eigen::Vector3f> begin_points;
  /// Points of the last 0.6 % of the scan's time, m, in the sensor's frame.
  std::vector<Eigen::Vector3f> end_points;
};

/// Checks the data of the sensors before they are used for mapping: rates, frames, units, times,
/// gravity, fixes. It checks the messages as they arrive, not the output of preprocessing.
class InputValidator {
 public:
  /// The configuration is that of the preprocessing which the data are meant for.
  explicit InputValidator(const PreprocessingConfig& config);
  ~InputValidator();

  /// A cloud has come, in the order of arrival as all that follow.
  void add_scan(const CloudSummary& cloud);
  /// A sample has come, in the units of its message and the axes of its frame. `delay`, here and
  /// below: s from the stamp to the delivery, if it is known.
  void add_imu(const ImuSample& sample, const std::string& frame_id,
               std::optional<double> delay = std::nullopt);
  /// A velocity has come, in the axes of its frame.
  void add_velocity(const VelocitySample& sample, const std::string& frame_id,
                    std::optional<double> delay = std::nullopt);
  /// A fix has come; `frame_id` is that of the antenna.
  void add_gnss(const GnssFix& fix, const std::string& frame_id,
                std::optional<double> delay = std::nullopt);

  /// Reports on points, imu, velocity and gnss, in this order. A missing input is a fault only if
  /// it is the points.
  std::vector<InputReport> report(const ExtrinsicLookup& lookup) const;

 private:
  struct Records;

  PreprocessingConfig config_;
  std::unique_ptr<Records> records_;
};

}  // namespace lidar_mapping::preprocessing
