// SPDX-License-Identifier: BSD-3-Clause
#include "files/whole_folder.hpp"

#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

/// Where the older folder waits while it is replaced.
fs::path aside(const fs::path& directory) { return hidden_beside(directory, ".old"); }

/// Whoever was killed while it replaced the folder has left the older one aside, and none in its
/// place.
void put_back(const fs::path& directory) {
  const fs::path old = aside(directory);
  if (fs::exists(old) && !fs::exists(directory)) fs::rename(old, directory);
}

/// Replaces an older folder by a finished one.
void replace_folder(const fs::path& finished, const fs::path& directory) {
  const fs::path old = aside(directory);
  fs::remove_all(old);
  if (fs::exists(directory)) fs::rename(directory, old);
  std::error_code failure;
  fs::rename(finished, directory, failure);
  if (failure) {
    put_back(directory);
    throw fs::filesystem_error("cannot rename", finished, directory, failure);
  }
  fs::remove_all(old);
}

/// Brings the files to the disk, all at once: there may be thousands.
void synchronise(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool is_done = descriptor >= 0 && ::syncfs(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!is_done) throw FileError("cannot bring " + folder.string() + " to the disk");
}

}  // namespace

void write_whole_folder(const fs::path& directory, const char* mark, const char* content,
                        const std::function<void(const fs::path& folder)>& write) {
  const fs::path target = folder_path(directory);
  std::error_code ignored;
  try {
    put_back(target);
  } catch (const fs::filesystem_error& error) {
    throw FileError("cannot write " + directory.string() + ": " + error.what());
  }
  if (fs::exists(directory) && !fs::exists(directory / mark)) {
    throw FileError(directory.string() + " is there already and holds no " + content +
                    "; name another directory");
  }
  const fs::path temporary = hidden_beside(target, ".part");
  try {
    fs::remove_all(temporary);
    fs::create_directories(temporary);
    write(temporary);
    synchronise(temporary);
    replace_folder(temporary, target);
  } catch (const fs::filesystem_error& error) {
    fs::remove_all(temporary, ignored);
    throw FileError("cannot write " + directory.string() + ": " + error.what());
  } catch (...) {
    fs::remove_all(temporary, ignored);
    throw;
  }
}

}  // namespace lidar_mapping::map
