// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

/// Name under which configurations() of a session holds where its map was imported from.
constexpr const char* kImportedMap = "import_map";

/// Whether the session was made of a map from elsewhere, by import_map, and not of a drive. Throws
/// FileError.
inline bool is_imported_map(const Session& session) {
  return session.configurations().count(kImportedMap) > 0;
}

}  // namespace lidar_mapping::session
