// SPDX-License-Identifier: BSD-3-Clause
#include "drive/drive_window.hpp"

#include <algorithm>
#include <deque>
#include <map>

#include "gnss/gnss_delay.hpp"

namespace lidar_mapping::back_end {

namespace {

// Key frames. Chosen: a wider window costs more time, at a narrower one's border a correction has
// not decayed; then the whole graph is solved.
constexpr int kWindowSteps = 50;
// m and rad: corrections that a window can absorb, because they decay within it. Chosen: 1 % of a
// window of 30 m (kWindowSteps at small steps); larger corrections change the whole drive.
constexpr double kSmallCorrection_m = 0.3;
constexpr double kSmallCorrection_rad = 0.02;

const DriveNode& node_at(const DriveGraph& drive, int position) { return drive.nodes[position]; }

/// `joined`: for each segment the group that used loops join it to. A loop that joins two of them
/// moves the whole of one.
bool is_small_correction(const DriveGraph& drive, const std::vector<int>& joined,
                         const DriveLoop& loop) {
  if (joined[drive.segment_of(loop.from)] != joined[drive.segment_of(loop.to)]) return false;
  const Pose there = node_at(drive, loop.from).T_map_base * loop.loop.T_from_to;
  const Vector6d gap = difference(node_at(drive, loop.to).T_map_base, there);
  return gap.head<3>().norm() < kSmallCorrection_m && gap.tail<3>().norm() < kSmallCorrection_rad;
}

bool is_small_correction(const DriveGraph& drive, const DriveGnss& gnss) {
  const GnssPosition p = delay_corrected_position(drive, gnss);
  const Eigen::Vector3d gap =
      node_at(drive, gnss.node).T_map_base * p.p_base_antenna - p.p_enu_antenna;
  return gap.head<2>().norm() < kSmallCorrection_m;
}

/// Nodes with new constraints; empty if one of the corrections is not small.
std::optional<std::vector<int>> nodes_with_new_data(const DriveGraph& drive,
                                                    const BackEndConfig& config) {
  std::vector<int> result;
  const std::vector<int> joined = connected_segments(drive, false);
  for (const DriveLoop& loop : drive.loops) {
    if (!config.use_loop_close || loop.evaluated) continue;
    if (!is_small_correction(drive, joined, loop)) return std::nullopt;
    result.insert(result.end(), {loop.from, loop.to});
  }
  const std::vector<bool> in_enu = segments_in_enu(drive);
  for (const DriveGnss& gnss : drive.gnss) {
    if (!config.use_gnss || config.georeference_only || gnss.evaluated) continue;
    if (!in_enu[drive.segment_of(gnss.node)]) return std::nullopt;
    if (!is_small_correction(drive, gnss)) return std::nullopt;
    result.push_back(gnss.node);
  }
  return result;
}

std::multimap<int, int> loop_partners(const DriveGraph& drive) {
  std::multimap<int, int> partners;
  for (const DriveLoop& loop : drive.loops) {
    if (loop.evaluated && !loop.used) continue;
    partners.emplace(loop.from, loop.to);
    partners.emplace(loop.to, loop.from);
  }
  return partners;
}

/// Number of steps from the nodes with new constraints to each node around them, up to one more
/// than kWindowSteps at the border.
std::map<int, int> steps_from(const DriveGraph& drive, const std::vector<int>& start_nodes) {
  const std::multimap<int, int> partners = loop_partners(drive);
  std::map<int, int> steps_to;
  std::deque<int> queue;
  const auto visit = [&](int node, int steps) {
    if (steps_to.emplace(node, steps).second) queue.push_back(node);
  };
  for (const int start : start_nodes) visit(start, 0);
  while (!queue.empty()) {
    const int node = queue.front();
    queue.pop_front();
    const int steps = steps_to.at(node) + 1;
    if (steps > kWindowSteps + 1) continue;
    if (node_at(drive, node).connected) visit(node - 1, steps);
    const int next = node + 1;
    if (next < static_cast<int>(drive.nodes.size()) && node_at(drive, next).connected) {
      visit(next, steps);
    }
    const auto [begin, end] = partners.equal_range(node);
    for (auto partner = begin; partner != end; ++partner) visit(partner->second, steps);
  }
  return steps_to;
}

/// Position in the window of a node, which has to be in it.
int position_in_window(const DriveWindow& window, int node) {
  const auto found = std::lower_bound(window.nodes.begin(), window.nodes.end(), node);
  return static_cast<int>(found - window.nodes.begin());
}

/// The values that belong to nodes of the window, with the numbers of the window.
template <typename Value>
std::vector<Value> in_window(const std::vector<Value>& values, const DriveWindow& window) {
  std::vector<Value> result;
  for (const int node : window.nodes) {
    const auto found = first_from(node, values);
    if (found == values.end() || found->node != node) continue;
    result.push_back(*found);
    result.back().node = position_in_window(window, node);
  }
  return result;
}

}  // namespace

std::optional<DriveWindow> window_around_new_data(const DriveGraph& drive,
                                                  const BackEndConfig& config) {
  const auto seed_nodes = nodes_with_new_data(drive, config);
  if (!seed_nodes || seed_nodes->empty()) return std::nullopt;
  const std::map<int, int> steps_to = steps_from(drive, *seed_nodes);
  if (4 * steps_to.size() > drive.nodes.size()) return std::nullopt;
  DriveWindow window;
  for (const auto& [node, steps] : steps_to) {
    window.nodes.push_back(node);
    window.fixed.push_back(steps > kWindowSteps);
  }
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    const bool inside =
        steps_to.count(drive.loops[i].from) > 0 && steps_to.count(drive.loops[i].to) > 0;
    if (inside) window.loops.push_back(static_cast<int>(i));
  }
  return window;
}

DriveGraph extract_window(const DriveGraph& drive, const DriveWindow& window) {
  DriveGraph part;
  for (std::size_t i = 0; i < window.nodes.size(); ++i) {
    part.nodes.push_back(node_at(drive, window.nodes[i]));
    const bool next = i > 0 && window.nodes[i] == window.nodes[i - 1] + 1;
    part.nodes.back().connected = part.nodes.back().connected && next;
    part.nodes.back().fixed = window.fixed[i];
  }
  for (const int i : window.loops) {
    part.loops.push_back(drive.loops[i]);
    part.loops.back().from = position_in_window(window, part.loops.back().from);
    part.loops.back().to = position_in_window(window, part.loops.back().to);
  }
  const auto& [gnss, imu, floors] = static_cast<const NodeMeasurements&>(drive);
  static_cast<NodeMeasurements&>(part) = {in_window(gnss, window), in_window(imu, window),
                                          in_window(floors, window)};
  // The loops that connect a segment with an aligned one may lie outside of the window.
  part.in_enu = segments_in_enu(drive);
  part.gnss_delays = drive.gnss_delays;
  part.odometry_errors = drive.odometry_errors;
  return part;
}

}  // namespace lidar_mapping::back_end
