// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "factors/drive_factors.hpp"

namespace lidar_mapping::back_end {

/// Adds the positions of the segments in East-North-Up; horizontal position and altitude are
/// separate constraints.
void add_gnss(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors);
/// Adds the headings that were measured with positions.
void add_headings(const DriveGraph& drive, const BackEndConfig& config,
                  pose_graph::FactorGraph& graph);

}  // namespace lidar_mapping::back_end
