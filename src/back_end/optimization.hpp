// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/back_end/back_end.hpp"

#include "drive_window.hpp"

namespace lidar_mapping::back_end {

struct OptimizationProblem {
  BackEndConfig config;
  DriveGraph drive;                   ///< the whole drive, or a window of it
  std::optional<DriveWindow> window;  ///< where the drive is a window: of what
  std::size_t key_frames = 0;         ///< of the whole drive
  UsageCounts usage;                  ///< on the whole drive, so far
  bool thorough = false;              ///< judge every loop and position anew
};

struct OptimizationSolution {
  DriveGraph drive;  ///< with the new poses and judgements
  std::optional<DriveWindow> window;
  std::size_t key_frames = 0;
  bool full_solve_needed = false;  ///< the window could not settle what is new
  OptimizationReport report;
};

}  // namespace lidar_mapping::back_end
