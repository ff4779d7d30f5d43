// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace lidar_mapping::ros_border {

/// The first bytes of a file, with zeros behind its end; empty if there is no such file.
std::string beginning_of(const std::string& path, std::size_t length);

/// A recording that is read by positions.
class FileBytes {
 public:
  /// Throws FileError if it cannot be opened. Each error names the file as a `kind` ("bag") and
  /// ends with `remedy`.
  FileBytes(std::string path, std::string kind, std::string remedy);
  ~FileBytes();
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  /// Number of bytes.
  std::uint64_t size() const { return size_; }
  /// Throws FileError if the file has no such bytes.
  void read(std::uint64_t position, void* to, std::size_t size) const;
  std::vector<std::uint8_t> read(std::uint64_t position, std::uint64_t size) const;
  /// Asks the system to read these bytes in advance.
  void prefetch(std::uint64_t position, std::uint64_t size) const;
  /// "cannot read the KIND PATH: REASON; REMEDY".
  std::string error(const std::string& reason) const;
  /// Throws FileError of that text, the second after "REASON at byte POSITION".
  [[noreturn]] void fail(const std::string& reason) const;
  [[noreturn]] void fail(const std::string& reason, std::uint64_t position) const;

 private:
  std::string path_;
  std::string kind_;
  std::string remedy_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace lidar_mapping::ros_border
