// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::ros_border {

/// Parameters beside the nodes that hold what a run needs when nodes are killed and start again. A
/// node that ends as asked deletes its own; mapping.launch deletes all at its start.
constexpr const char* kRunDatum = "run_state/gnss_datum";  ///< latitude, longitude, altitude
constexpr const char* kRunSession = "run_state/session";   ///< its folder

}  // namespace lidar_mapping::ros_border
