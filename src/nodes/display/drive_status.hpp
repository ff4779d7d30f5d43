// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <visualization_msgs/Marker.h>

namespace lidar_mapping::ros_border {

/// State of the drive for the display.
struct DriveStatus {
  std::string state;    ///< of the front end: tracking, degenerate, doubtful, degraded or lost;
                        ///< empty: no scan
  bool silent = false;  ///< whether scans have stopped
  std::string problem;  ///< why there are no scans, if known
  std::size_t key_frames = 0;
  /// Key frames that have come since the last answer of optimize_map; none: it was not called.
  std::optional<std::size_t> since_optimized;
  double length = 0.0;  ///< m, along the key frames
  std::size_t loops_used = 0;
  std::size_t loops_refused = 0;
  std::string optimize_map = "/optimize_map";  ///< name of the service
  std::string save_map = "/save_map";          ///< name of the service
};

/// The status as a text that faces the viewer, namespace status: over the vehicle in `base_frame`
/// once there are key frames, before that at the origin of `map_frame`. White if all is well,
/// orange if odometry is poor, red if it is lost.
visualization_msgs::Marker status_text(const DriveStatus& status, const std::string& map_frame,
                                       const std::string& base_frame);

}  // namespace lidar_mapping::ros_border
