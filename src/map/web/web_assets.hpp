// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace lidar_mapping::map {

/// A file of the page in a browser, from src/map/web.
struct WebAsset {
  const char* name;  ///< Relative to the folder of the page.
  const char* text;
};

/// All of them; web_assets.cpp.in takes them into the program, so that nothing has to be installed.
const std::vector<WebAsset>& web_assets();

}  // namespace lidar_mapping::map
