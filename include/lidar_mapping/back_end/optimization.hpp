#pragma once

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/back_end/drive_graph.hpp"

namespace lidar_mapping::back_end {

struct OptimizationProblem {
  BackEndConfig config;
  DriveGraph drive;
  bool thorough = false;  ///< judge every loop and position anew
};

struct OptimizationSolution {
  DriveGraph drive;  ///< with the new poses and judgements
  OptimizationReport report;
};

}  // namespace lidar_mapping::back_end
