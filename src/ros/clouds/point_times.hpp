// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include "clouds/time_fields.hpp"

namespace lidar_mapping::ros_border {

/// Converts the points' times to seconds and finds their unit and reference. With the span `read`
/// scan.cloud.times have the values of the field, else they are read here. There are no times if
/// the driver does not fill the fields.
void decode_times(const CloudView& message, const TimeFields& fields,
                  const preprocessing::PreprocessingConfig& config,
                  const std::optional<preprocessing::TimeSpan>& read, DecodedCloud& result);

}  // namespace lidar_mapping::ros_border
