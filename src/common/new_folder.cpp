// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/new_folder.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

namespace fs = std::filesystem;

void check_new_folder(const fs::path& folder) {
  if (!fs::exists(folder)) return;
  if (fs::is_directory(folder) && fs::is_empty(folder)) return;
  throw FileError(folder.string() + " exists and is no empty folder; name a new one");
}

fs::path folder_path(const fs::path& folder) {
  return fs::absolute(folder / ".").lexically_normal().parent_path();
}

fs::path hidden_beside(const fs::path& folder, const std::string& ending) {
  const fs::path whole = folder_path(folder);
  return whole.parent_path() / ("." + whole.filename().string() + ending);
}

}  // namespace lidar_mapping
