#pragma once

#include <memory>
#include <optional>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/back_end/factor_graph.hpp"

namespace lidar_mapping::back_end {

/// How well the graph knows a key frame's pose in the map, given all that it believes: the block of
/// the inverse information matrix at the present poses. None for an unknown key frame or a graph
/// that leaves poses free. Takes about as long as one step of the solver.
std::optional<Covariance6> marginal_covariance(const OptimizationProblem& problem,
                                               KeyFrameIndex index);

/// The smallest eigenvalue of the information matrix of all marked constraints at the present
/// states, by inverse iteration; its units are mixed (1/m^2, and 1/rad^2 of half angles). Near 0
/// where the constraints leave a motion free, 0 where they do so to rounding. Nodes that no
/// constraint touches must not be there.
double least_eigenvalue(const FactorGraph& graph, const std::vector<bool>& marked);

}  // namespace lidar_mapping::back_end
