// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/pose_graph.hpp"

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// The results of BackEnd in the forms of its public functions.
KeyFramePoses poses_of(const DriveGraph& drive, std::uint32_t revision);
KeyFramePoses odometry_of(const DriveGraph& drive, std::uint32_t revision);
std::vector<std::pair<Loop, bool>> loops_of(const DriveGraph& drive);
std::vector<GnssPosition> positions_of(const DriveGraph& drive);
std::vector<int> parts_of(const DriveGraph& drive);
bool is_in_enu(const DriveGraph& drive);
pose_graph::PoseGraph pose_graph_of(const DriveGraph& drive, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
