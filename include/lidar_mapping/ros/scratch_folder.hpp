// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace lidar_mapping::ros_border {

/// A folder for files that a node needs only while it runs: TMPDIR/lidar_mapping-NAME-PID. It is
/// removed with this object; that of a killed process of the same name is removed when the next one
/// starts. Throws FileError if it cannot be made.
class ScratchFolder {
 public:
  /// `name` is that of the node; slashes of namespaces are replaced.
  explicit ScratchFolder(const std::string& name);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  /// The folder, which exists and is empty at first.
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace lidar_mapping::ros_border
