// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"

#include "localization/localized_scan.hpp"

namespace lidar_mapping::tools {

/// check_new_folder() for a new session. Throws FileError, too, if the folder for the results is
/// the same or lies in it.
void check_session_folder(const std::filesystem::path& session,
                          const std::filesystem::path& results);

/// localization.csv (doc/localization.md): a row for each scan. Positions also in degrees and in
/// UTM if the map has a datum.
std::string localization_csv(const std::vector<LocalizedScan>& scans,
                             const std::optional<GeodeticDatum>& datum);

/// Writes trajectory/localized.tum, trajectory/laser_odom_scans.tum and localization.csv; the
/// folder is made. The bytes depend on the results alone. Throws FileError.
void write_localization(const std::filesystem::path& folder,
                        const std::vector<LocalizedScan>& scans,
                        const std::optional<GeodeticDatum>& datum);

}  // namespace lidar_mapping::tools
