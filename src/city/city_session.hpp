// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "city_graph.hpp"

namespace lidar_mapping::city {

/// Writes the city as one session with solved poses, which all other commands read. Clouds are hard
/// links to those of the drives where the disk allows that, so they take no space twice. Beside the
/// files of every session it holds `drives/NAME.tum`: the poses of each drive with its own stamps.
/// Settings and the position of the LiDAR come from the first drive. `folder` must not exist or be
/// empty; it appears when it is complete. Throws FileError, and InputError if no drive is in the
/// city.
void write_city(const JoinedCity& city, const back_end::BackEndConfig& config,
                const std::filesystem::path& folder);

}  // namespace lidar_mapping::city
