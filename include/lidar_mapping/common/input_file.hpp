// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>

namespace lidar_mapping {

/// Opens a text file for reading. Throws FileError with the reason: a folder is no file to a user,
/// but opens like one.
std::ifstream open_for_reading(const std::filesystem::path& path);

}  // namespace lidar_mapping
