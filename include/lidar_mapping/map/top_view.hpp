// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "lidar_mapping/map/cloud_parts.hpp"

namespace lidar_mapping::map {

/// Picture of the map from above: x to the right, y up; the colour shows the height above the local
/// ground.
struct TopView {
  int width = 0;                  ///< Pixels along x.
  int height = 0;                 ///< Pixels along y.
  double pixel_m = 0.0;           ///< Edge of a pixel, m.
  double x_min = 0.0;             ///< Left border in the map frame, m.
  double y_max = 0.0;             ///< Upper border in the map frame, m.
  std::vector<std::uint8_t> rgb;  ///< Three bytes per pixel, uppermost row first.
};

/// Draws the map. A pixel shows its highest point: grey-blue at the ground, then green and yellow,
/// and red from 10 m on; the brightness grows with the number of points. Pixels are `pixel_m` wide,
/// or wider if the picture would have more than `max_pixels` on a side. Points far outside of all
/// but one of five thousand on each side are left out, because a few reflections would make
/// everything else small. Throws InputError for a map
/// without points.
TopView top_view(const CloudParts& map, double pixel_m, int max_pixels = 4000);

/// Writes a PNG file and beside it a world file (.pgw: pixel size and centre of the upper left
/// pixel). Throws FileError.
void write_png(const std::filesystem::path& path, const TopView& view);

}  // namespace lidar_mapping::map
