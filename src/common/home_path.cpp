// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/home_path.hpp"

#include <cstdlib>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

namespace fs = std::filesystem;

fs::path expanded_path(const std::string& text) {
  if (text.empty()) return {};
  if (text[0] != '~') return fs::absolute(text).lexically_normal();
  if (text.size() > 1 && text[1] != '/') {
    throw InputError("'" + text + "': of paths with ~ only those with ~/ (one's own home folder) " +
                     "are understood; give the whole path");
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') {
    throw InputError("'" + text + "': HOME is not set, so ~ has no meaning; give the whole path");
  }
  return fs::absolute(home + text.substr(1)).lexically_normal();
}

}  // namespace lidar_mapping
