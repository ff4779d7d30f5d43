#pragma once

#include <cstddef>
#include <string>

namespace lidar_mapping {

/// Header of a binary PCD file (version 0.7) with x y z intensity as floats; behind it come that
/// many Points as they are in memory.
std::string pcd_header(std::size_t points);

}  // namespace lidar_mapping
