#include "lidar_mapping/back_end/drive_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lidar_mapping/back_end/edge_covariance.hpp"
#include "lidar_mapping/back_end/vertical.hpp"

namespace lidar_mapping::back_end {

namespace {

// The prior of the first node: where nothing else says where the map is it is the only say; beside
// GNSS it only keeps the directions that positions cannot observe (the roll about a straight road).
constexpr double kFirmStddev_m = 1e-3;
constexpr double kFirmStddev_rad = 1e-4;
constexpr double kWeakStddev_m = 1e3;
constexpr double kWeakHeadingStddev_rad = 10.0;
constexpr double kWeakTiltStddev_rad = 0.05;
constexpr double kRadPerDeg = M_PI / 180.0;

/// Of place and heading, and of the tilt, each firm or weak.
Covariance6 prior_covariance(const Pose& T_map_base, bool firm_place, bool firm_tilt) {
  const Eigen::Vector3d up_base = T_map_base.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double tilt = firm_tilt ? kFirmStddev_rad : kWeakTiltStddev_rad;
  const double heading = firm_place ? kFirmStddev_rad : kWeakHeadingStddev_rad;
  Covariance6 covariance = diagonal_covariance(firm_place ? kFirmStddev_m : kWeakStddev_m, tilt);
  covariance.bottomRightCorner<3, 3>() +=
      (heading * heading - tilt * tilt) * up_base * up_base.transpose();
  return covariance;
}

void add_priors(const DriveGraph& drive, bool with_gnss, bool with_vertical, FactorGraph& graph) {
  const std::vector<int> connected = connected_segments(drive, true);
  for (std::size_t segment = 0; segment < drive.segment_starts.size(); ++segment) {
    const int node = drive.segment_starts[segment];
    const Pose& pose =
        segment == 0 ? drive.T_map_first : drive.nodes[static_cast<std::size_t>(node)].T_map_base;
    // A segment that hangs on another needs no prior; a weak one keeps it solvable should its
    // loops be refused.
    const bool alone = connected[segment] == static_cast<int>(segment);
    const bool firm = alone && !(with_gnss && drive.in_enu[segment]);
    const Covariance6 covariance = prior_covariance(pose, firm, firm && !with_vertical);
    graph.add({prior_residual(pose, g2o_information(covariance)), node});
  }
}

void add_odometry(const DriveGraph& drive, const BackEndConfig& config, FactorGraph& graph) {
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    const DriveNode& previous = drive.nodes[i - 1];
    const DriveNode& node = drive.nodes[i];
    if (!node.joined) continue;
    const Pose T_previous_node = previous.T_odom_base.inverse() * node.T_odom_base;
    const int to = static_cast<int>(i);
    graph.add({relative_pose_residual(T_previous_node, g2o_information(node.motion_covariance)),
               to - 1, to, false, config.odometry_robust_kernel, config.robust_kernel_size});
  }
}

/// By how much each position's covariance grows because its neighbours share its error.
std::vector<double> shared_errors(const DriveGraph& drive, const BackEndConfig& config) {
  std::vector<double> factors(drive.gnss.size(), 1.0);
  const auto place = [&](std::size_t i) {
    return drive.nodes[static_cast<std::size_t>(drive.gnss[i].node)].T_odom_base.translation;
  };
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::size_t before = i == 0 ? i : i - 1;
    const std::size_t after = std::min(i + 1, factors.size() - 1);
    if (after == before) continue;
    const double spacing = ((place(i) - place(before)).norm() + (place(after) - place(i)).norm()) /
                           static_cast<double>(after - before);
    factors[i] = std::max(1.0, config.gnss_correlation_distance / std::max(spacing, 0.1));
  }
  return factors;
}

/// The segments that hang together with one that lies in East-North-Up.
std::vector<bool> segments_in_enu(const DriveGraph& drive) {
  const std::vector<int> connected = connected_segments(drive, true);
  std::vector<bool> group(connected.size(), false);
  for (std::size_t s = 0; s < connected.size(); ++s) {
    if (drive.in_enu[s]) group[static_cast<std::size_t>(connected[s])] = true;
  }
  std::vector<bool> result(connected.size());
  for (std::size_t s = 0; s < connected.size(); ++s) {
    result[s] = group[static_cast<std::size_t>(connected[s])];
  }
  return result;
}

Eigen::Matrix2d horizontal_covariance(const GnssPosition& position, const BackEndConfig& config) {
  const double least = config.gnss_min_stddev_m;
  return position.covariance.topLeftCorner<2, 2>() + least * least * Eigen::Matrix2d::Identity();
}

void add_gnss(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  const std::vector<bool> in_enu = segments_in_enu(drive);
  const std::vector<double> growth = shared_errors(drive, config);
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    const DriveGnss& gnss = drive.gnss[i];
    if (!in_enu[static_cast<std::size_t>(drive.segment_of(gnss.node))]) continue;
    const GnssPosition& p = gnss.position;
    factors.horizontal_of[i] = static_cast<int>(factors.graph.constraints.size());
    factors.graph.add({antenna_horizontal_residual(p.p_enu_antenna, p.p_base_antenna,
                                                   growth[i] * horizontal_covariance(p, config)),
                       gnss.node, -1, true, config.gnss_robust_kernel, config.robust_kernel_size});
    if (!has_altitude(p)) continue;
    factors.altitude_of[i] = static_cast<int>(factors.graph.constraints.size());
    factors.graph.add({antenna_altitude_residual(p.p_enu_antenna.z(), p.p_base_antenna,
                                                 std::sqrt(growth[i]) * altitude_stddev(p, config)),
                       gnss.node, -1, true, config.gnss_robust_kernel, config.robust_kernel_size});
  }
}

void add_loops(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    const DriveLoop& loop = drive.loops[i];
    if (loop.loop.decision == LoopDecision::kRefuse) continue;
    // What a person accepted stands as firm as odometry: no kernel, no refusal.
    const bool open = loop.loop.decision == LoopDecision::kAuto;
    factors.loop_of[i] = static_cast<int>(factors.graph.constraints.size());
    const Matrix6d information = g2o_information(loop_covariance(loop.loop, config));
    factors.graph.add({relative_pose_residual(loop.loop.T_from_to, information), loop.from, loop.to,
                       open, open ? config.loop_robust_kernel : RobustKernel::kNone,
                       config.robust_kernel_size});
  }
}

void add_verticals(const DriveGraph& drive, const BackEndConfig& config, FactorGraph& graph) {
  for (const Vertical& vertical : verticals(drive, config)) {
    graph.add({tilt_residual(vertical.up_base, vertical.stddev), vertical.node, -1, false,
               config.imu_robust_kernel, config.robust_kernel_size});
  }
}

void add_headings(const DriveGraph& drive, const BackEndConfig& config, FactorGraph& graph) {
  const std::vector<bool> in_enu = segments_in_enu(drive);
  for (const DriveGnss& gnss : drive.gnss) {
    if (!gnss.position.R_enu_base) continue;
    if (!in_enu[static_cast<std::size_t>(drive.segment_of(gnss.node))]) continue;
    graph.add({heading_residual(yaw_of(*gnss.position.R_enu_base),
                                config.imu_heading_stddev_deg * kRadPerDeg),
               gnss.node, -1, false, config.imu_robust_kernel, config.robust_kernel_size});
  }
}

Eigen::Matrix3d floor_covariance(const BackEndConfig& config) {
  const double angle = config.floor_stddev_deg * kRadPerDeg;
  const Eigen::Vector3d stddev(angle, angle, config.floor_stddev_m);
  return stddev.cwiseAbs2().asDiagonal();
}

void add_floor_pairs(const DriveGraph& drive, const BackEndConfig& config, FactorGraph& graph) {
  for (std::size_t i = 1; i < drive.floors.size(); ++i) {
    const DriveFloor& a = drive.floors[i - 1];
    const DriveFloor& b = drive.floors[i];
    // Floors further apart need not lie in one plane.
    if (b.node != a.node + 1 || !drive.nodes[static_cast<std::size_t>(b.node)].joined) continue;
    const Eigen::Matrix3d covariance =
        a.floor.covariance + b.floor.covariance + floor_covariance(config);
    graph.add({common_floor_residual(a.floor, b.floor, covariance), a.node, b.node, false,
               config.floor_robust_kernel, config.robust_kernel_size});
  }
}

/// Where the first floor lies: its z axis is the normal.
Pose plane_pose(const DriveGraph& drive, const DriveFloor& first) {
  const Pose& T_map_base = drive.nodes[static_cast<std::size_t>(first.node)].T_map_base;
  const Eigen::Vector3d normal = T_map_base.rotation * first.floor.normal;
  return {Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal),
          T_map_base.translation - first.floor.offset * normal};
}

/// A node of its own stands for the plane, so that no single floor decides about it.
void add_floor_plane(const DriveGraph& drive, const BackEndConfig& config, FactorGraph& graph) {
  if (drive.floors.empty()) return;
  const Pose pose = plane_pose(drive, drive.floors.front());
  const int plane = graph.add_node(pose);
  Vector6d stddev;  // a plane is free in height and tilt; along itself it must be held
  stddev << 1.0, 1.0, kWeakStddev_m, kWeakHeadingStddev_rad, kWeakHeadingStddev_rad, 1.0;
  graph.add({prior_residual(pose, g2o_information(stddev.cwiseAbs2().asDiagonal())), plane});
  for (const DriveFloor& floor : drive.floors) {
    const Eigen::Matrix3d covariance = floor.floor.covariance + floor_covariance(config);
    graph.add({common_floor_residual(Floor{}, floor.floor, covariance), plane, floor.node, false,
               config.floor_robust_kernel, config.robust_kernel_size});
  }
}

/// Believed so far, or not judged yet.
std::vector<bool> marks(const DriveGraph& drive, const DriveFactors& factors) {
  std::vector<bool> marked(factors.graph.constraints.size(), true);
  const auto mark = [&](int constraint, bool used, bool weighed) {
    if (constraint >= 0) marked[static_cast<std::size_t>(constraint)] = used || !weighed;
  };
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    mark(factors.loop_of[i], drive.loops[i].used, drive.loops[i].weighed);
  }
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    mark(factors.horizontal_of[i], drive.gnss[i].horizontal_used, drive.gnss[i].weighed);
    mark(factors.altitude_of[i], drive.gnss[i].altitude_used, drive.gnss[i].weighed);
  }
  return marked;
}

}  // namespace

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

DriveFactors make_factors(const DriveGraph& drive, const BackEndConfig& config) {
  DriveFactors factors;
  factors.loop_of.assign(drive.loops.size(), -1);
  factors.horizontal_of.assign(drive.gnss.size(), -1);
  factors.altitude_of.assign(drive.gnss.size(), -1);
  for (const DriveNode& node : drive.nodes) {
    factors.graph.add_node(node.T_map_base, node.held);
  }
  const bool with_gnss = config.use_gnss && !config.georeference_only;
  const bool with_vertical =
      !drive.imu.empty() && (config.enable_imu_orientation || config.enable_imu_acceleration);
  add_priors(drive, with_gnss, with_vertical, factors.graph);
  add_odometry(drive, config, factors.graph);
  add_verticals(drive, config, factors.graph);
  if (with_gnss && config.enable_imu_heading) add_headings(drive, config, factors.graph);
  switch (config.floor_constraint) {
    case FloorConstraint::kNone:
      break;
    case FloorConstraint::kNeighbours:
      add_floor_pairs(drive, config, factors.graph);
      break;
    case FloorConstraint::kPlane:
      add_floor_plane(drive, config, factors.graph);
      break;
  }
  if (config.use_loop_close) add_loops(drive, config, factors);
  if (with_gnss) add_gnss(drive, config, factors);
  factors.marked = marks(drive, factors);
  return factors;
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

double horizontal_stddev(const GnssPosition& position, const BackEndConfig& config) {
  return std::sqrt(0.5 * horizontal_covariance(position, config).trace());
}

double altitude_stddev(const GnssPosition& position, const BackEndConfig& config) {
  return std::hypot(std::sqrt(position.covariance(2, 2)), config.gnss_min_stddev_altitude_m);
}

bool has_altitude(const GnssPosition& position) {
  return std::isfinite(position.p_enu_antenna.z()) && position.covariance(2, 2) > 0.0 &&
         std::isfinite(position.covariance(2, 2));
}

}  // namespace lidar_mapping::back_end
