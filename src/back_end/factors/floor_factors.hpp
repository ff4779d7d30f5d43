// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Adds constraints between nodes by the floors below them, as `floor_constraint` says.
void add_floors(const DriveGraph& drive, const BackEndConfig& config,
                pose_graph::FactorGraph& graph);

}  // namespace lidar_mapping::back_end
