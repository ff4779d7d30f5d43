// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/moving_objects/change_list.hpp"

namespace lidar_mapping::map {

/// The instants between which something came or went: the end of the earlier visit and the
/// beginning of the later one.
std::pair<Stamp, Stamp> interval_of(const moving_objects::Change& change,
                                    const std::vector<moving_objects::Visit>& visits);

/// Writes changes.geojson, a footprint for each change with kind, size, height above the map's zero
/// and the dates between which it happened, and changes.pcd with the points of all changes in the
/// map frame: their intensity is the number of the change, negative for what has disappeared.
/// Without changes there is no changes.pcd, nor one of an older map. Without a datum the first file
/// is named as that of write_geojson(). Throws like write_pcd().
Files write_changes(const std::vector<moving_objects::Change>& changes,
                    const std::vector<moving_objects::Visit>& visits,
                    const std::optional<GeodeticDatum>& datum,
                    const std::filesystem::path& directory);

}  // namespace lidar_mapping::map
