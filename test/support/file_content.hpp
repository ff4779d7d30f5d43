// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

namespace lidar_mapping::test {

/// All bytes of a file; none if it cannot be read.
inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Content of all files below a folder, by their paths in it.
inline std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[std::filesystem::relative(entry.path(), folder)] = content_of(entry.path());
  }
  return files;
}

/// The number that begins at a byte, as it is in memory.
template <typename Number>
Number number_at(const std::string& bytes, std::size_t position) {
  Number number;
  std::memcpy(&number, bytes.data() + position, sizeof number);
  return number;
}

}  // namespace lidar_mapping::test
