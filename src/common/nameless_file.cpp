// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/nameless_file.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

namespace fs = std::filesystem;

NamelessFile::NamelessFile(const fs::path& directory) : directory_(directory) {
  std::error_code problem;
  fs::create_directories(directory, problem);
  if (problem) fail(problem.message());
  // mkstemp() puts its own letters in the place of the last six.
  std::string name = (directory / ".aside.").string() + std::string(6, 'X');
  descriptor_ = ::mkstemp(name.data());
  if (descriptor_ < 0) fail(std::strerror(errno));
  ::unlink(name.c_str());
}

NamelessFile::~NamelessFile() { ::close(descriptor_); }

void NamelessFile::write(std::uint64_t offset, const void* data, std::size_t bytes) {
  const char* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const auto written = ::pwrite(descriptor_, from, bytes, static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(std::strerror(errno));
    from += written;
    offset += static_cast<std::uint64_t>(written);
    bytes -= static_cast<std::size_t>(written);
  }
}

void NamelessFile::read(std::uint64_t offset, void* data, std::size_t bytes) const {
  char* to = static_cast<char*>(data);
  while (bytes > 0) {
    const auto got = ::pread(descriptor_, to, bytes, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(got == 0 ? "they end too early" : std::strerror(errno));
    to += got;
    offset += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
}

void NamelessFile::fail(const std::string& reason) const {
  throw FileError("cannot put data aside in " + directory_.string() + ": " + reason +
                  "; check the free space and the permissions");
}

}  // namespace lidar_mapping
