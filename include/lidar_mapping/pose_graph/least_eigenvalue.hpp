// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// The smallest eigenvalue of the information matrix of all marked constraints at the present
/// states, by inverse iteration; its units are mixed (1/m^2, and 1/rad^2 of half angles). Near 0
/// where the constraints leave a motion free, 0 where they do so to rounding. Nodes that no
/// constraint touches must not be there.
double least_eigenvalue(const FactorGraph& graph, const std::vector<bool>& selected);

}  // namespace lidar_mapping::pose_graph
