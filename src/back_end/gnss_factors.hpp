// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drive_factors.hpp"

namespace lidar_mapping::back_end {

/// Positions of the segments that lie in East-North-Up, horizontal and altitude apart.
void add_gnss(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors);
/// Headings that came with positions.
void add_headings(const DriveGraph& drive, const BackEndConfig& config,
                  pose_graph::FactorGraph& graph);

}  // namespace lidar_mapping::back_end
