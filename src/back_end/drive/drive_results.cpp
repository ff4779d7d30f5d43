// SPDX-License-Identifier: BSD-3-Clause
#include "drive/drive_results.hpp"

#include <algorithm>

#include "lidar_mapping/pose_graph/residuals.hpp"

#include "gnss/gnss_delay.hpp"
#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {

KeyFramePoses poses_of(const DriveGraph& drive, std::uint32_t revision) {
  KeyFramePoses result;
  result.revision = revision;
  result.poses.reserve(drive.nodes.size());
  for (const DriveNode& node : drive.nodes) {
    result.poses.push_back({node.index, node.stamp, node.T_map_base});
  }
  return result;
}

KeyFramePoses odometry_of(const DriveGraph& drive, std::uint32_t revision) {
  KeyFramePoses result = poses_of(drive, revision);
  if (drive.nodes.empty()) return result;
  const DriveNode& first = drive.nodes.front();
  const Pose T_map_odom = first.T_map_base * first.T_odom_base.inverse();
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    result.poses[i].T_map_base = T_map_odom * drive.nodes[i].T_odom_base;
  }
  return result;
}

std::vector<std::pair<Loop, bool>> loops_of(const DriveGraph& drive) {
  std::vector<std::pair<Loop, bool>> result;
  for (const DriveLoop& loop : drive.loops) {
    result.emplace_back(loop.loop, loop.used || !loop.evaluated);
  }
  return result;
}

std::vector<GnssPosition> positions_of(const DriveGraph& drive) {
  std::vector<GnssPosition> result;
  for (const DriveGnss& gnss : drive.gnss) result.push_back(delay_corrected_position(drive, gnss));
  return result;
}

std::vector<int> parts_of(const DriveGraph& drive) {
  std::vector<int> part_of = connected_segments(drive, false);
  const std::vector<bool> in_enu = groups_in_enu(drive, part_of);
  const auto first = std::find(in_enu.begin(), in_enu.end(), true) - in_enu.begin();
  for (int& part : part_of) {
    if (in_enu[part]) part = static_cast<int>(first);
  }
  std::vector<int> result;
  for (const DriveNode& node : drive.nodes) {
    result.push_back(part_of[node.segment]);
  }
  return result;
}

bool is_in_enu(const DriveGraph& drive) {
  const std::vector<int> connected = connected_segments(drive, false);
  const std::vector<bool> in_enu = groups_in_enu(drive, connected);
  const auto aligned =
      std::count_if(drive.nodes.begin(), drive.nodes.end(),
                    [&](const DriveNode& node) { return in_enu[connected[node.segment]]; });
  return 2 * static_cast<std::size_t>(aligned) > drive.nodes.size();
}

pose_graph::PoseGraph pose_graph_of(const DriveGraph& drive, const BackEndConfig& config) {
  pose_graph::PoseGraph graph;
  for (const DriveNode& node : drive.nodes) graph.nodes.push_back({node.index, node.T_map_base});
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    const DriveNode& a = drive.nodes[i - 1];
    const DriveNode& b = drive.nodes[i];
    if (!b.connected) continue;
    graph.edges.push_back({a.index, b.index, motion_to(drive, i),
                           pose_graph::g2o_information(motion_covariance_to(drive, i, config))});
  }
  for (const DriveLoop& loop : drive.loops) {
    if (!loop.used) continue;
    graph.edges.push_back({loop.loop.from, loop.loop.to, loop.loop.T_from_to,
                           pose_graph::g2o_information(loop_covariance(loop.loop, config))});
  }
  return graph;
}

}  // namespace lidar_mapping::back_end
