// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::ros_border {

/// x y z intensity as floats, and `time` (seconds relative to the stamp) where there are times.
/// Throws InputError if the points do not fit into a message (check_cloud_size()).
sensor_msgs::PointCloud2 to_message(const PointCloud& cloud, Stamp stamp,
                                    const std::string& frame_id);

/// The points of a cloud of this package: fields x y z [intensity] [time], all FLOAT32. Points that
/// are not finite are left out. Throws InputError if a field has another type or the data are
/// shorter than the header says. Clouds of sensors go through decode() of the preprocessing.
PointCloud from_message(const sensor_msgs::PointCloud2& message);

}  // namespace lidar_mapping::ros_border
