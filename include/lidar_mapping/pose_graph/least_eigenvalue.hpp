// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// The smallest eigenvalue of the information matrix of all selected constraints at the current
/// states, by inverse iteration. Its units are mixed: 1/m^2, and 1/rad^2 of half angles. It is near
/// 0 if the constraints hardly determine a motion, and 0 if they do not determine it within
/// rounding errors. Each node needs at least one constraint.
double least_eigenvalue(const FactorGraph& graph, const std::vector<bool>& selected);

}  // namespace lidar_mapping::pose_graph
