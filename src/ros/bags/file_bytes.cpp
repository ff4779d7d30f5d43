// SPDX-License-Identifier: BSD-3-Clause
#include "bags/file_bytes.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

std::string beginning_of(const std::string& path, std::size_t length) {
  if (!std::filesystem::is_regular_file(path)) return "";
  std::string text(length, '\0');
  std::ifstream(path, std::ios::binary).read(text.data(), static_cast<std::streamsize>(length));
  return text;
}

FileBytes::FileBytes(std::string path, std::string kind, std::string remedy)
    : path_(std::move(path)), kind_(std::move(kind)), remedy_(std::move(remedy)) {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw FileError("cannot read the " + kind_ + " " + path_ + ": " + std::strerror(errno) +
                    "; check its path and permissions");
  }
  struct stat status {};
  ::fstat(descriptor_, &status);
  size_ = static_cast<std::uint64_t>(status.st_size);
}

FileBytes::~FileBytes() { ::close(descriptor_); }

void FileBytes::read(std::uint64_t position, void* to, std::size_t size) const {
  auto* at = static_cast<std::uint8_t*>(to);
  while (size > 0) {
    const ssize_t got = ::pread(descriptor_, at, size, static_cast<off_t>(position));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(std::strerror(errno));
    if (got == 0) fail("its end is missing");
    at += got;
    position += static_cast<std::uint64_t>(got);
    size -= static_cast<std::size_t>(got);
  }
}

std::vector<std::uint8_t> FileBytes::read(std::uint64_t position, std::uint64_t size) const {
  if (position > size_ || size > size_ - position) fail("its end is missing");
  std::vector<std::uint8_t> bytes(size);
  read(position, bytes.data(), bytes.size());
  return bytes;
}

void FileBytes::prefetch(std::uint64_t position, std::uint64_t size) const {
  ::posix_fadvise(descriptor_, static_cast<off_t>(position), static_cast<off_t>(size),
                  POSIX_FADV_WILLNEED);
}

std::string FileBytes::error(const std::string& reason) const {
  return "cannot read the " + kind_ + " " + path_ + ": " + reason + "; " + remedy_;
}

void FileBytes::fail(const std::string& reason) const { throw FileError(error(reason)); }

void FileBytes::fail(const std::string& reason, std::uint64_t position) const {
  fail(reason + " at byte " + std::to_string(position));
}

}  // namespace lidar_mapping::ros_border
