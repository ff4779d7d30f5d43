// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/session/session.hpp"

#include "session_folder.hpp"

// Sessions that appear only when they are complete.
namespace lidar_mapping::session {

namespace {

namespace fs = std::filesystem;

/// Fills a session in the folder `temporary` and then moves it to the folder that destination()
/// returns.
Session create_aside(const fs::path& temporary, const std::function<void(Session&)>& fill,
                     const std::function<fs::path()>& destination) {
  fs::path target;
  try {
    fs::remove_all(temporary);
    {
      Session session = Session::create_in(temporary);
      fill(session);
    }
    target = destination();
    fs::rename(temporary, target);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
  return Session::open(target, Session::Access::kWrite);
}

}  // namespace

Session create_filled(const fs::path& directory, const std::function<void(Session&)>& fill) {
  check_new_folder(fs::absolute(directory).lexically_normal());
  const fs::path target = folder_path(directory);
  return create_aside(hidden_beside(target, ".part"), fill, [&] { return target; });
}

Session create_filled(const fs::path& root, std::time_t now,
                      const std::function<void(Session&)>& fill) {
  return create_aside(root / (".loaded." + std::to_string(::getpid()) + ".part"), fill,
                      [&] { return make_run_folder(root, now); });
}

}  // namespace lidar_mapping::session
