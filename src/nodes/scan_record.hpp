// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::ros_border {

/// What a session keeps of the status of a scan.
inline session::ScanRecord to_record(const FrontEndStatusMessage& status) {
  return {from_ros(status.header.stamp),
          status.repeated ? "repeated" : status.state,
          status.fitness,
          status.overlap,
          status.seconds,
          std::int64_t{status.scans_dropped},
          status.unobserved_stddev,
          status.elevation_shift,
          status.probability};
}

}  // namespace lidar_mapping::ros_border
