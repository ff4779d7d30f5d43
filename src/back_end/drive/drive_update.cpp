// SPDX-License-Identifier: BSD-3-Clause
#include "drive/drive_update.hpp"

#include <algorithm>

namespace lidar_mapping::back_end {

namespace {

/// Computes the poses of nodes that were added during a solution by odometry from the previous
/// nodes.
void propagate_odometry(std::size_t first, DriveGraph& drive) {
  for (std::size_t i = first; i < drive.nodes.size(); ++i) {
    const DriveNode& previous = drive.nodes[i - 1];
    drive.nodes[i].T_map_base =
        previous.T_map_base * previous.T_odom_base.inverse() * drive.nodes[i].T_odom_base;
  }
}

void copy_usage(const DriveGnss& solved, int node, DriveGraph& drive) {
  const auto found = first_from(node, drive.gnss);
  found->horizontal_used = solved.horizontal_used;
  found->altitude_used = solved.altitude_used;
  found->evaluated = solved.evaluated;
}

}  // namespace

void apply_whole_solution(const DriveGraph& solved, DriveGraph& drive) {
  drive.T_map_first = solved.T_map_first;
  std::copy(solved.in_enu.begin(), solved.in_enu.end(), drive.in_enu.begin());
  std::copy(solved.gnss_delays.begin(), solved.gnss_delays.end(), drive.gnss_delays.begin());
  drive.odometry_errors = solved.odometry_errors;
  for (std::size_t i = 0; i < solved.nodes.size(); ++i) {
    drive.nodes[i].T_map_base = solved.nodes[i].T_map_base;
  }
  propagate_odometry(solved.nodes.size(), drive);
  std::copy(solved.loops.begin(), solved.loops.end(), drive.loops.begin());
  for (const DriveGnss& gnss : solved.gnss) copy_usage(gnss, gnss.node, drive);
}

void apply_window_solution(const DriveGraph& solved, const DriveWindow& window,
                           std::size_t key_frames, DriveGraph& drive) {
  for (std::size_t i = 0; i < window.nodes.size(); ++i) {
    drive.nodes[window.nodes[i]].T_map_base = solved.nodes[i].T_map_base;
  }
  propagate_odometry(key_frames, drive);
  for (std::size_t i = 0; i < window.loops.size(); ++i) {
    DriveLoop& loop = drive.loops[window.loops[i]];
    loop.used = solved.loops[i].used;
    loop.evaluated = solved.loops[i].evaluated;
  }
  for (const DriveGnss& gnss : solved.gnss) {
    copy_usage(gnss, window.nodes[gnss.node], drive);
  }
}

}  // namespace lidar_mapping::back_end
