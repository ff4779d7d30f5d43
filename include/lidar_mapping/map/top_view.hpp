// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "lidar_mapping/map/cloud_parts.hpp"

namespace lidar_mapping::map {

/// A picture of the map from above: x to the right, y up, colour by height above the local ground.
struct TopView {
  int width = 0;
  int height = 0;
  double pixel_m = 0.0;
  double x_min = 0.0;             ///< m, left border
  double y_max = 0.0;             ///< m, upper border
  std::vector<std::uint8_t> rgb;  ///< rows from above, 3 bytes a pixel
};

/// A pixel shows the highest point in it: grey-blue at the ground, over green and yellow, to red at
/// 10 m and more; brightness follows the number of points. Pixels are `pixel_m` wide, or wider
/// where the picture would be more than `max_pixels` on a side. Throws InputError for a map without
/// points.
TopView top_view(const CloudParts& map, double pixel_m, int max_pixels = 4000);

/// Writes a PNG file and a world file (.pgw: pixel size and the centre of the upper left pixel)
/// beside it. Throws FileError.
void write_png(const std::filesystem::path& path, const TopView& view);

}  // namespace lidar_mapping::map
