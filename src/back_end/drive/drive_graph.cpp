// SPDX-License-Identifier: BSD-3-Clause
#include "drive/drive_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "imu/vertical.hpp"
#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {

std::vector<int> connected_segments(const DriveGraph& drive, bool with_unevaluated_loops) {
  std::vector<int> smallest(drive.in_enu.size());
  std::iota(smallest.begin(), smallest.end(), 0);
  for (const DriveLoop& loop : drive.loops) {
    if (!loop.used && !(with_unevaluated_loops && !loop.evaluated)) continue;
    const int a = smallest[drive.segment_of(loop.from)];
    const int b = smallest[drive.segment_of(loop.to)];
    std::replace(smallest.begin(), smallest.end(), std::max(a, b), std::min(a, b));
  }
  return smallest;
}

std::vector<bool> groups_in_enu(const DriveGraph& drive, const std::vector<int>& connected) {
  std::vector<bool> result(connected.size(), false);
  for (std::size_t s = 0; s < connected.size(); ++s) {
    if (drive.in_enu[s]) result[connected[s]] = true;
  }
  return result;
}

std::vector<bool> segments_in_enu(const DriveGraph& drive) {
  const std::vector<int> connected = connected_segments(drive, true);
  const std::vector<bool> group_in_enu = groups_in_enu(drive, connected);
  std::vector<bool> result;
  for (const int group : connected) result.push_back(group_in_enu[group]);
  return result;
}

namespace {

const Floor* floor_at(const DriveGraph& drive, int node) {
  const auto found = first_from(node, drive.floors);
  return found != drive.floors.end() && found->node == node ? &found->floor : nullptr;
}

/// Fraction of the drift in height, roll and pitch that remains for a motion between two floors.
/// The noise of the floors from one key frame to the next must not be taken for drift: floors give
/// no information on a drift that is smaller than their noise.
double drift_fraction_between_floors(const DriveGraph& drive, std::size_t node,
                                     const Vector6d& drift, const BackEndConfig& config) {
  if (config.floor_constraint != FloorConstraint::kNeighbours) return 1.0;
  const Floor* before = floor_at(drive, static_cast<int>(node) - 1);
  const Floor* after = floor_at(drive, static_cast<int>(node));
  if (before == nullptr || after == nullptr) return 1.0;
  const Eigen::Matrix3d scatter = neighbours_covariance(*before, *after, config);
  const double tilt = std::sqrt(std::max(scatter(0, 0), scatter(1, 1)));
  return std::min(1.0, drift(4) / tilt);
}

}  // namespace

Pose motion_to(const DriveGraph& drive, std::size_t node) {
  Pose motion = drive.nodes[node - 1].T_odom_base.inverse() * drive.nodes[node].T_odom_base;
  motion.translation *= 1.0 + drive.odometry_errors.scale_error;
  return motion;
}

Covariance6 motion_covariance_to(const DriveGraph& drive, std::size_t node,
                                 const BackEndConfig& config) {
  Vector6d drift = drift_stddev(motion_to(drive, node), config);
  Vector6d fraction = drive.odometry_errors.drift_fraction;
  const double between_floors = drift_fraction_between_floors(drive, node, drift, config);
  fraction.segment<3>(2) = fraction.segment<3>(2).cwiseMin(between_floors);
  drift = drift.cwiseProduct(fraction);
  Covariance6 covariance = drive.nodes[node].step_covariance;
  covariance.diagonal() += drift.cwiseAbs2();
  return covariance;
}

UsageCounts count_usage(const DriveGraph& drive) {
  UsageCounts counts;
  for (const DriveLoop& loop : drive.loops) {
    (loop.used ? counts.loops_used : counts.loops_refused) += 1;
  }
  counts.gnss_refused = drive.unusable_gnss;
  for (const DriveGnss& gnss : drive.gnss) {
    (gnss.horizontal_used ? counts.gnss_used : counts.gnss_refused) += 1;
  }
  return counts;
}

Eigen::Quaterniond gravity_alignment(const DriveGraph& drive, const std::vector<bool>& segments,
                                     const BackEndConfig& config) {
  Eigen::Vector3d up_map = Eigen::Vector3d::Zero();
  for (const Vertical& vertical : verticals(drive, config)) {
    if (!segments[drive.segment_of(vertical.node)]) continue;
    up_map += drive.nodes[vertical.node].T_map_base.rotation * vertical.up_base /
              (vertical.stddev * vertical.stddev);
  }
  if (up_map.norm() == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond::FromTwoVectors(up_map, Eigen::Vector3d::UnitZ());
}

}  // namespace lidar_mapping::back_end
