// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/preprocessing/input_validator.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/cloud_view.hpp"

namespace lidar_mapping::ros_border {

/// Format of a cloud, for messages to the user.
using CloudFormat = preprocessing::CloudFormat;

/// A cloud as input of preprocessing, and its format.
struct DecodedCloud {
  preprocessing::RawScan scan;  ///< points (m) and times (s)
  CloudFormat format;           ///< what the message held
};

/// A PointCloud2 of any driver: x y z as FLOAT32 or FLOAT64, and intensities and times of any
/// number type from the fields that drivers have for them (kIntensityNames and kTimeNames in
/// common/point_field_names.hpp). Times are of the unit that fits the scan's period (or
/// point_time_unit), or else of that which the name says or the type usually has, relative or
/// absolute; also in two fields, such as `time_sec` and `time_nsec` or `timestamp_h` and
/// `timestamp_l`. All points are kept in their order, also those that are not finite. Throws
/// InputError for big-endian data, missing coordinates, fields outside of the point and data that
/// are shorter than the header says.
DecodedCloud decode(const CloudView& message, const preprocessing::PreprocessingConfig& config);
/// The same, but points of the usual layout stay packed in the message's data, which `memory` keeps
/// and which live on with the scan, until they are moved. The memory of `buffer` is used again.
DecodedCloud decode_lazily(const CloudView& message, std::shared_ptr<const void> memory,
                           const preprocessing::PreprocessingConfig& config,
                           PointCloud buffer = {});

/// The properties of a cloud that the input validator checks.
preprocessing::CloudSummary summary_of(const CloudView& message, const DecodedCloud& decoded);

}  // namespace lidar_mapping::ros_border
