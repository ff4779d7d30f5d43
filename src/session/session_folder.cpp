// SPDX-License-Identifier: BSD-3-Clause
#include "session_folder.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "lidar_mapping/common/dates.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

namespace {

namespace fs = std::filesystem;

/// Creates a folder. Returns false if it existed; this is atomic, so that two processes cannot both
/// create it.
bool create_new(const fs::path& folder) {
  std::error_code error;
  const bool made = fs::create_directory(folder, error);
  if (error && error != std::errc::file_exists) {
    throw FileError("cannot make " + folder.string() + ": " + error.message() +
                    "; check the path and the permissions");
  }
  return made;
}

/// Replaces the link atomically. A file or folder with the name `latest` that is not a link is not
/// touched.
void link_latest_to(const fs::path& folder) {
  const fs::path link = folder.parent_path() / "latest";
  if (fs::exists(fs::symlink_status(link)) && !fs::is_symlink(link)) return;
  const fs::path temporary =
      folder.parent_path() / (".latest." + std::to_string(::getpid()) + ".part");
  std::error_code error;
  fs::remove(temporary, error);
  fs::create_directory_symlink(folder.filename(), temporary, error);
  if (!error) fs::rename(temporary, link, error);
}

}  // namespace

fs::path make_run_folder(const fs::path& root, std::time_t now) {
  std::error_code error;
  fs::create_directories(root, error);
  if (error) {
    throw FileError("cannot make " + root.string() + ": " + error.message() +
                    "; check the path and the permissions");
  }
  const std::string name = dated_name(now);
  fs::path folder = root / name;
  for (int number = 2; !create_new(folder); ++number) {
    folder = root / (name + "-" + std::to_string(number));
  }
  link_latest_to(folder);
  return folder;
}

WriteLock::WriteLock(const fs::path& folder)
    : descriptor_(::open((folder / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0) {
    throw FileError("cannot write in " + folder.string() + ": " + std::strerror(errno));
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  ::close(descriptor_);
  throw FileError("the session " + folder.string() +
                  " is being written by another process; end that one first");
}

WriteLock::~WriteLock() { ::close(descriptor_); }

fs::path find_session(const fs::path& path) {
  for (const fs::path& candidate : {path, path / "latest"}) {
    if (fs::is_regular_file(candidate / "session.db")) return fs::canonical(candidate);
  }
  throw FileError("there is no session in " + path.string() +
                  " (no session.db there, nor in a folder `latest` in it)");
}

}  // namespace lidar_mapping::session
