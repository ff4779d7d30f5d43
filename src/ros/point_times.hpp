// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"

namespace lidar_mapping::ros_border {

/// The field of the points' times, or null.
const sensor_msgs::PointField* time_field(const CloudView& message);

/// Converts the points' times to seconds and finds their unit and reference. With the span `read`
/// scan.cloud.times have the values of the field, else they are read here. There are no times if
/// the driver does not fill the field.
void decode_times(const CloudView& message, const sensor_msgs::PointField& field,
                  const preprocessing::PreprocessingConfig& config,
                  const std::optional<preprocessing::TimeSpan>& read, DecodedCloud& result);

}  // namespace lidar_mapping::ros_border
