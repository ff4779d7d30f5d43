// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/scratch_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <optional>

#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

namespace fs = std::filesystem;

std::string prefix_for(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return "lidar_mapping-" + name + "-";
}

/// The process that a folder of this prefix belongs to; nothing for other files.
std::optional<pid_t> owner_of(const fs::path& folder, const std::string& prefix) {
  const std::string name = folder.filename().string();
  if (name.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  pid_t pid = 0;
  const char* const end = name.data() + name.size();
  const auto result = std::from_chars(name.data() + prefix.size(), end, pid);
  if (result.ec != std::errc() || result.ptr != end || pid <= 0) return std::nullopt;
  return pid;
}

/// Whether another process of this number runs. If it is that of this process, a killed one has had
/// it before, as happens in a container that is started again.
bool is_of_another(pid_t pid) { return pid != getpid() && (kill(pid, 0) == 0 || errno != ESRCH); }

void remove_left_behind(const fs::path& parent, const std::string& prefix) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(parent, ignored)) {
    const auto owner = owner_of(entry.path(), prefix);
    if (owner && !is_of_another(*owner)) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

ScratchFolder::ScratchFolder(const std::string& name) {
  const std::string prefix = prefix_for(name);
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  path_ = parent / (prefix + std::to_string(getpid()));
  if (!error) {
    remove_left_behind(parent, prefix);
    fs::create_directories(path_, error);
  }
  if (error) {
    throw FileError("cannot make the folder " + path_.string() + ": " + error.message() +
                    "; set TMPDIR to a folder that can be written");
  }
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace lidar_mapping::ros_border
