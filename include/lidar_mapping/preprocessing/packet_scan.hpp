// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

namespace lidar_mapping::preprocessing {

/// A scan from packets of a sensor.
struct PacketScan {
  PointCloud cloud;      ///< m, in the axes of the driver (z up); times in s after a stamp
  TimeSpan span;         ///< of the times
  std::string contents;  ///< for the user: "76 packets of a Velodyne VLP-16"
  std::size_t damaged_packets = 0;  ///< left out, as their blocks are not those of the sensor
};

}  // namespace lidar_mapping::preprocessing
