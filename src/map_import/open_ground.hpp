// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "ground_cells.hpp"

namespace lidar_mapping::map_import {

/// A cell of the ground on which a vehicle can stand.
struct OpenCell {
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();  ///< its middle, m
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();    ///< normal of the ground, of length 1
  /// Steps from cell to cell up to the border of the open ground; 1 beside it.
  int clearance = 0;
};

/// The cells (sorted, as ground_cells() gives them) that are surrounded by ground of about the same
/// height and connected to an area of some tens of square metres. So the tops of walls and of cars
/// are left out, and each storey counts that ground leads to; what lies above another ground and is
/// not connected to it is a ceiling. They are in the order of `cells`.
std::vector<OpenCell> find_open_ground(const std::vector<GroundCell>& cells);

}  // namespace lidar_mapping::map_import
