// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "point_tiles.hpp"

namespace lidar_mapping::map_import {

/// Edge of the columns in which the ground is sought, m. Chosen: a vehicle covers some of them, and
/// one holds points also of a thinned map.
constexpr double kGroundCell = 1.0;

/// Ground in a column of the map.
struct GroundCell {
  int column = 0;       ///< along x, of kGroundCell
  int row = 0;          ///< along y, of kGroundCell
  double height = 0.0;  ///< in the map, m
};

/// Heights (m, rising) of the grounds among the heights of all points of a column, one for each
/// storey: a thin layer with two metres above it that are free. The top of a wall is such a layer,
/// too; find_open_ground() tells it from ground.
std::vector<float> ground_heights(std::vector<float> heights);

/// The grounds of all columns of a map, by column, row and height.
std::vector<GroundCell> ground_cells(PointTiles& tiles);

}  // namespace lidar_mapping::map_import
