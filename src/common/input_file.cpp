// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/input_file.hpp"

#include <cerrno>
#include <cstring>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

std::ifstream open_for_reading(const std::filesystem::path& path) {
  std::error_code none;
  if (std::filesystem::is_directory(path, none)) {
    throw FileError("cannot read " + path.string() + ": it is a folder; name the file in it");
  }
  std::ifstream file(path);
  if (!file) {
    throw FileError("cannot read " + path.string() + ": " + std::strerror(errno) +
                    "; check the path and the permissions");
  }
  return file;
}

}  // namespace lidar_mapping
