// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/new_folder.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

void check_new_folder(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder)) return;
  if (std::filesystem::is_directory(folder) && std::filesystem::is_empty(folder)) return;
  throw FileError(folder.string() + " exists and is no empty folder; name a new one");
}

}  // namespace lidar_mapping
