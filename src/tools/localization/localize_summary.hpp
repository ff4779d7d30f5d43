// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/pipeline/map_extender.hpp"

#include "json.hpp"
#include "localization/localized_scan.hpp"

namespace lidar_mapping::tools {

/// The run in figures: when the place was found, how many scans had which state, agreement with the
/// map, processor time of a scan.
json::Json localization_figures(const std::vector<LocalizedScan>& scans);

/// The same figures as lines for a person.
std::string localization_text(const json::Json& figures);

/// What became of the extension of the map, as lines for a person. `session` is the folder of the
/// new session, if there is one.
std::string extension_text(const pipeline::ExtensionReport& report, const std::string& session);

}  // namespace lidar_mapping::tools
