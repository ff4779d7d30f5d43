// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// The part of a drive that new constraints influence.
struct DriveWindow {
  std::vector<int> nodes;   ///< numbers of the nodes in the drive, increasing
  std::vector<bool> fixed;  ///< per node: at the border and therefore constant
  std::vector<int> loops;   ///< numbers of the loops with both ends in the window
};

/// The window around all loops and GNSS positions that are not evaluated yet: all nodes within 50
/// steps along odometry and loops. Empty if the whole graph has to be solved, because a new
/// constraint would move it by more than decimetres, connects segments, or because the window would
/// be more than a quarter of the graph.
std::optional<DriveWindow> window_around_new_data(const DriveGraph& drive,
                                                  const BackEndConfig& config);

/// The window as a drive of its own.
DriveGraph extract_window(const DriveGraph& drive, const DriveWindow& window);

}  // namespace lidar_mapping::back_end
