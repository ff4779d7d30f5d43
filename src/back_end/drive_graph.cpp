#include "lidar_mapping/back_end/drive_graph.hpp"

#include <algorithm>
#include <numeric>

#include "lidar_mapping/back_end/vertical.hpp"

namespace lidar_mapping::back_end {

std::vector<int> connected_segments(const DriveGraph& drive, bool with_unweighed_loops) {
  std::vector<int> least(drive.in_enu.size());
  std::iota(least.begin(), least.end(), 0);
  for (const DriveLoop& loop : drive.loops) {
    if (!loop.used && !(with_unweighed_loops && !loop.weighed)) continue;
    const int a = least[static_cast<std::size_t>(drive.segment_of(loop.from))];
    const int b = least[static_cast<std::size_t>(drive.segment_of(loop.to))];
    std::replace(least.begin(), least.end(), std::max(a, b), std::min(a, b));
  }
  return least;
}

Judgements count_judgements(const DriveGraph& drive) {
  Judgements counts;
  for (const DriveLoop& loop : drive.loops) {
    (loop.used ? counts.loops_used : counts.loops_refused) += 1;
  }
  counts.gnss_refused = drive.unusable_gnss;
  for (const DriveGnss& gnss : drive.gnss) {
    (gnss.horizontal_used ? counts.gnss_used : counts.gnss_refused) += 1;
  }
  return counts;
}

Eigen::Quaterniond levelling(const DriveGraph& drive, const std::vector<bool>& segments,
                             const BackEndConfig& config) {
  Eigen::Vector3d up_map = Eigen::Vector3d::Zero();
  for (const Vertical& vertical : verticals(drive, config)) {
    if (!segments[static_cast<std::size_t>(drive.segment_of(vertical.node))]) continue;
    up_map += drive.nodes[static_cast<std::size_t>(vertical.node)].T_map_base.rotation *
              vertical.up_base / (vertical.stddev * vertical.stddev);
  }
  if (up_map.norm() == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond::FromTwoVectors(up_map, Eigen::Vector3d::UnitZ());
}

}  // namespace lidar_mapping::back_end
