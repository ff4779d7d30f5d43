// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "drive_graph.hpp"

namespace lidar_mapping::back_end {

/// The part of a drive that new constraints touch.
struct DriveWindow {
  std::vector<int> nodes;   ///< positions, increasing
  std::vector<bool> fixed;  ///< those at the border, which do not move
  std::vector<int> loops;   ///< positions of the loops with both ends in the window
};

/// The window around all loops and GNSS positions that no solution has judged yet: what lies within
/// 50 steps along odometry and loops. None where they call for the whole graph: because they would
/// move it by more than decimetres, join segments, or touch a good part of it anyway.
std::optional<DriveWindow> window_around_new_data(const DriveGraph& drive,
                                                  const BackEndConfig& config);

/// The window as a drive of its own.
DriveGraph extract_window(const DriveGraph& drive, const DriveWindow& window);

}  // namespace lidar_mapping::back_end
