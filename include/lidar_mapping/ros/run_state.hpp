// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <istream>
#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::ros_border {

/// Parameters in the namespace of the nodes with the state of a run, for nodes that are killed and
/// restarted. A node deletes its own at a regular shutdown; mapping.launch deletes all at its
/// start.
constexpr const char* kRunDatum = "run_state/gnss_datum";  ///< latitude, longitude, altitude
constexpr const char* kRunSession = "run_state/session";   ///< its folder
/// The node that is reading a session to go on with, until it answers. mapping.launch sets it, too,
/// because scans may come before that node has begun.
constexpr const char* kRunResuming = "run_state/resuming";
/// The datum of the session, and the run that goes on there.
constexpr const char* kSessionDatum = "run_state/session_datum";

/// As text with all digits, because a ROS master may round numbers.
std::string to_text(const GeodeticDatum& datum);
/// Reads such a text; empty if there is none.
std::optional<GeodeticDatum> read_datum(std::istream& text);

}  // namespace lidar_mapping::ros_border
