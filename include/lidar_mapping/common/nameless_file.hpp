// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace lidar_mapping {

/// A file without a name in some folder, which is gone with the process, however it ends. Any
/// thread may read. Throws FileError.
class NamelessFile {
 public:
  /// Makes the file in `directory`, and the folder where it is missing.
  explicit NamelessFile(const std::filesystem::path& directory);
  ~NamelessFile();
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  /// Writes `bytes` bytes at `offset` (bytes from the beginning); the file grows as needed.
  void write(std::uint64_t offset, const void* data, std::size_t bytes);
  /// Reads `bytes` bytes that were written from `offset` on; fails if the file is shorter.
  void read(std::uint64_t offset, void* data, std::size_t bytes) const;

 private:
  [[noreturn]] void fail(const std::string& reason) const;

  std::filesystem::path directory_;
  int descriptor_ = -1;
};

}  // namespace lidar_mapping
