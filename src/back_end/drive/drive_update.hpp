// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive/drive_window.hpp"

namespace lidar_mapping::back_end {

/// Copies poses and decisions of a solved drive into the current drive. Nodes that were added
/// during the solution follow by odometry.
void apply_whole_solution(const DriveGraph& solved, DriveGraph& drive);
/// The same for a window; the drive had `key_frames` nodes when the solution began.
void apply_window_solution(const DriveGraph& solved, const DriveWindow& window,
                           std::size_t key_frames, DriveGraph& drive);

}  // namespace lidar_mapping::back_end
