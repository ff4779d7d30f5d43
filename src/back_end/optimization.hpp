// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/back_end/back_end.hpp"

#include "drive/drive_window.hpp"

namespace lidar_mapping::back_end {

struct OptimizationProblem {
  BackEndConfig config;
  DriveGraph drive;                   ///< the whole drive, or a window of it
  std::optional<DriveWindow> window;  ///< nodes and loops of the window; empty for the whole drive
  std::size_t key_frames = 0;         ///< number in the whole drive
  UsageCounts usage;                  ///< counts in the whole drive before the solution
  bool thorough = false;              ///< evaluate every loop and position again
};

struct OptimizationSolution {
  DriveGraph drive;  ///< with the new poses and decisions
  std::optional<DriveWindow> window;
  std::size_t key_frames = 0;
  bool full_solve_needed = false;  ///< the window was not sufficient for the new constraints
  OptimizationReport report;
};

}  // namespace lidar_mapping::back_end
