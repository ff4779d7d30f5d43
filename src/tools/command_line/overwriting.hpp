// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::tools {

/// Throws FileError if one of the output files (empty: none) exists, unless `force` allows to
/// overwrite it.
inline void check_overwriting(const std::vector<std::string>& files, bool force) {
  for (const std::string& file : files) {
    if (force || file.empty() || !std::filesystem::exists(file)) continue;
    throw FileError(file + " exists; name another file, or give --force to overwrite it");
  }
}

}  // namespace lidar_mapping::tools
