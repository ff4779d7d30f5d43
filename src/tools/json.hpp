#pragma once

#include <nlohmann/json.hpp>

namespace lidar_mapping::tools {

/// Keys in the order in which they were added; by name with versions before 3.9 (Ubuntu 20.04).
#if NLOHMANN_JSON_VERSION_MAJOR > 3 || NLOHMANN_JSON_VERSION_MINOR >= 9
using Json = nlohmann::ordered_json;
#else
using Json = nlohmann::json;
#endif

}  // namespace lidar_mapping::tools
