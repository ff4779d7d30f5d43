// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include <unistd.h>

namespace lidar_mapping::test {

/// A folder of the test's own, gone at the end of its scope.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    // mkdtemp() puts its own letters in the place of the last six.
    std::string name =
        (std::filesystem::temp_directory_path() / "lidar_mapping_").string() + std::string(6, 'X');
    if (mkdtemp(name.data()) == nullptr) throw std::filesystem::filesystem_error("mkdtemp", {});
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace lidar_mapping::test
