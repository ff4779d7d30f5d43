// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace lidar_mapping::json {

/// Keys in the order in which they were added; by name with versions before 3.9 (Ubuntu 20.04).
#if NLOHMANN_JSON_VERSION_MAJOR > 3 || NLOHMANN_JSON_VERSION_MINOR >= 9
using Json = nlohmann::ordered_json;
#else
using Json = nlohmann::json;
#endif

/// The value as text. Names of files and texts of a damaged session may contain bytes that are not
/// UTF-8, for which the library's own dump() throws; they become U+FFFD.
inline std::string dumped(const Json& json, int indentation = -1) {
  return json.dump(indentation, ' ', false, Json::error_handler_t::replace);
}

}  // namespace lidar_mapping::json
