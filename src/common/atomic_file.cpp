// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/atomic_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw FileError("cannot write " + path.string() + ": " + reason +
                  "; check the free space and the permissions");
}

/// Brings the content of a file, or the names in a folder, to the disk.
void sync(const fs::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags);
  if (descriptor < 0) fail(path, std::strerror(errno));
  const int result = ::fsync(descriptor);
  const int problem = errno;
  ::close(descriptor);
  if (result != 0) fail(path, std::strerror(problem));
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

}  // namespace

void write_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  std::error_code unknown;
  if (fs::is_other(fs::status(path, unknown))) return write(path);
  const fs::path folder = folder_of(path);
  const fs::path temporary = folder / ("." + path.filename().string() + ".part");
  try {
    fs::create_directories(folder);
    write(temporary);
    sync(temporary, O_RDONLY);
    fs::rename(temporary, path);
    sync(folder, O_RDONLY | O_DIRECTORY);
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    fail(path, error.what());
  }
}

void write_stream_atomically(const fs::path& path,
                             const std::function<void(std::ostream&)>& write) {
  write_atomically(path, [&](const fs::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    write(file);
    file.close();
    if (file) return;
    // Which of its writes failed first, and why, is not known any more.
    throw FileError("cannot write " + path.string() + "; check the free space and the permissions");
  });
}

void write_text_atomically(const fs::path& path, const std::string& text) {
  write_atomically(path, [&](const fs::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file << text;
    file.close();
    if (!file) fail(path, std::strerror(errno));
  });
}

}  // namespace lidar_mapping
