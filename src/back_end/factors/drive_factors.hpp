// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/pose_graph/factor_graph.hpp"

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// The factor graph of a drive, with the constraint of each of its measurements.
struct DriveFactors {
  pose_graph::FactorGraph graph;
  std::vector<bool> selected;      ///< per constraint: used so far, or not evaluated yet
  std::vector<int> motion_of;      ///< constraint between each node and the previous one; -1: none
  std::vector<int> loop_of;        ///< constraint of each loop; -1: none
  std::vector<int> horizontal_of;  ///< horizontal constraint of each GNSS position; -1: none
  std::vector<int> altitude_of;
};

/// True if there is such a constraint and the solution uses it.
inline bool is_used(int constraint, const std::vector<bool>& used) {
  return constraint >= 0 && used[constraint];
}

DriveFactors make_factors(const DriveGraph& drive, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
