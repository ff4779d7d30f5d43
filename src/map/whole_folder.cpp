// SPDX-License-Identifier: BSD-3-Clause
#include "whole_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

/// Replaces an older folder by a finished one.
void replace_folder(const fs::path& finished, const fs::path& directory) {
  const fs::path old = directory.parent_path() / ("." + directory.filename().string() + ".old");
  fs::remove_all(old);
  if (fs::exists(directory)) fs::rename(directory, old);
  fs::rename(finished, directory);
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
  if (fs::exists(directory) && !fs::exists(directory / mark)) {
    throw FileError(directory.string() + " is there already and holds no " + content +
                    "; name another directory");
  }
  const fs::path target = fs::absolute(directory / ".").lexically_normal().parent_path();
  const fs::path temporary = target.parent_path() / ("." + target.filename().string() + ".part");
  std::error_code ignored;
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
