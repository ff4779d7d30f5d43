#include "lidar_mapping/back_end/drive_graph.hpp"

#include <algorithm>
#include <numeric>

#include "lidar_mapping/back_end/edge_covariance.hpp"
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

Pose motion_to(const DriveGraph& drive, std::size_t node) {
  Pose motion = drive.nodes[node - 1].T_odom_base.inverse() * drive.nodes[node].T_odom_base;
  motion.translation *= 1.0 + drive.odometry_errors.stretch;
  return motion;
}

Covariance6 motion_covariance_to(const DriveGraph& drive, std::size_t node,
                                 const BackEndConfig& config) {
  const Vector6d drift =
      drive.odometry_errors.drift_share.cwiseProduct(drift_stddev(motion_to(drive, node), config));
  Covariance6 covariance = drive.nodes[node].step_covariance;
  covariance.diagonal() += drift.cwiseAbs2();
  return covariance;
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
