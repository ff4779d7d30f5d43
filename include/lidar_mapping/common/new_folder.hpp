// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace lidar_mapping {

/// Throws FileError if results cannot go into a new folder of this name, because something is there
/// that is no empty folder.
void check_new_folder(const std::filesystem::path& folder);

}  // namespace lidar_mapping
