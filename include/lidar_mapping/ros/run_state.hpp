// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::ros_border {

/// Parameters in the namespace of the nodes with the state of a run, for nodes that are killed and
/// restarted. A node deletes its own at a regular shutdown; mapping.launch deletes all at its
/// start.
constexpr const char* kRunDatum = "run_state/gnss_datum";  ///< latitude, longitude, altitude
constexpr const char* kRunSession = "run_state/session";   ///< its folder

}  // namespace lidar_mapping::ros_border
