// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace lidar_mapping::ros_border {

/// A recording that is read by positions.
class FileBytes {
 public:
  /// Throws FileError if it cannot be opened. `remedy` ends each error.
  FileBytes(std::string path, std::string remedy);
  ~FileBytes();
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  /// Number of bytes.
  std::uint64_t size() const { return size_; }
  /// Throws FileError if the file has no such bytes.
  void read(std::uint64_t position, void* to, std::size_t size) const;
  std::vector<std::uint8_t> read(std::uint64_t position, std::uint64_t size) const;
  /// "cannot read the recording PATH: REASON; REMEDY".
  std::string error(const std::string& reason) const;
  /// Throws FileError of that text.
  [[noreturn]] void fail(const std::string& reason) const;
  [[noreturn]] void fail(const std::string& reason, std::uint64_t position) const;

 private:
  std::string path_;
  std::string remedy_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace lidar_mapping::ros_border
