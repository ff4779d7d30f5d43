// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/common/key_frame.hpp"

#include "examined_drive.hpp"
#include "json.hpp"

namespace lidar_mapping::report {

/// What a drive that was localised in the map says of it (doc/map_quality.md): states of its scans,
/// when the place was found, agreement and coverage, where the place was lost, motion against
/// odometry, and each section of the map. Lengths in m, angles in deg, times in s since its first
/// scan.
json::Json examination_figures(const ExaminedDrive& drive, const KeyFramePoses& map);

/// The same as lines for a person, with at most so many sections, the worst first.
std::string examination_text(const json::Json& figures, std::size_t sections);

/// The verdict on a map by such a drive: a line of verdicts().
json::Json examination_verdict(const json::Json& figures);

}  // namespace lidar_mapping::report
