#pragma once

#include <memory>
#include <optional>

#include "lidar_mapping/back_end/back_end.hpp"

namespace lidar_mapping::back_end {

/// How well the graph knows a key frame's pose in the map, given all that it believes: the block of
/// the inverse information matrix at the present poses. None for an unknown key frame or a graph
/// that leaves poses free. Takes about as long as one step of the solver.
std::optional<Covariance6> marginal_covariance(const OptimizationProblem& problem,
                                               KeyFrameIndex index);

}  // namespace lidar_mapping::back_end
