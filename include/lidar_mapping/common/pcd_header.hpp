#pragma once

#include <cstddef>
#include <string>

namespace lidar_mapping {

/// Header of a PCD file (version 0.7) with x y z intensity as floats. Behind a "binary" one come
/// that many Points as they are in memory.
std::string pcd_header(std::size_t points, const std::string& data = "binary");

}  // namespace lidar_mapping
