// SPDX-License-Identifier: BSD-3-Clause
#include "drive_factors.hpp"

#include "edge_covariance.hpp"
#include "floor_factors.hpp"
#include "gnss_factors.hpp"
#include "vertical.hpp"

namespace lidar_mapping::back_end {

namespace {

// The prior of the first node: where nothing else says where the map is it is the only say; beside
// GNSS it only keeps the directions that positions cannot observe (the roll about a straight road).
constexpr double kFirmStddev_m = 1e-3;
constexpr double kFirmStddev_rad = 1e-4;
constexpr double kWeakStddev_m = 1e3;
constexpr double kWeakHeadingStddev_rad = 10.0;
constexpr double kWeakTiltStddev_rad = 0.05;

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

/// As the parameters have it, the squares of x y z roll pitch yaw.
Covariance6 asked_covariance(const BackEndConfig& config) {
  return Eigen::Map<const Vector6d>(config.fix_first_node_stddev.data()).cwiseAbs2().asDiagonal();
}

void add_priors(const DriveGraph& drive, const BackEndConfig& config, bool with_gnss,
                bool with_vertical, pose_graph::FactorGraph& graph) {
  const std::vector<int> connected = connected_segments(drive, true);
  for (std::size_t segment = 0; segment < drive.segment_starts.size(); ++segment) {
    const int node = drive.segment_starts[segment];
    const Pose& pose =
        segment == 0 ? drive.T_map_first : drive.nodes[static_cast<std::size_t>(node)].T_map_base;
    // A segment that hangs on another needs no prior; a weak one keeps it solvable should its
    // loops be refused.
    const bool alone = connected[segment] == static_cast<int>(segment);
    const bool firm = alone && !(with_gnss && drive.in_enu[segment]);
    const Covariance6 covariance = segment == 0 && config.fix_first_node
                                       ? asked_covariance(config)
                                       : prior_covariance(pose, firm, firm && !with_vertical);
    graph.add({pose_graph::prior_residual(pose, pose_graph::g2o_information(covariance)), node});
  }
}

// A step that is probably wrong holds where nothing else does, and gives way to what contradicts it
// by more than the error that is expected of it.
constexpr pose_graph::RobustKernel kDoubtfulKernel = pose_graph::RobustKernel::kCauchy;
constexpr double kDoubtfulKernelSize = 1.0;  // standard deviations

void add_odometry(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    if (!drive.nodes[i].joined) continue;
    const int to = static_cast<int>(i);
    factors.motion_of[i] = static_cast<int>(factors.graph.constraints.size());
    const Matrix6d information =
        pose_graph::g2o_information(motion_covariance_to(drive, i, config));
    const bool doubtful = drive.nodes[i].doubtful;
    factors.graph.add({pose_graph::relative_pose_residual(motion_to(drive, i), information), to - 1,
                       to, false, doubtful ? kDoubtfulKernel : config.odometry_robust_kernel,
                       doubtful ? kDoubtfulKernelSize : config.robust_kernel_size, doubtful});
  }
}

void add_loops(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    const DriveLoop& loop = drive.loops[i];
    if (loop.loop.decision == LoopDecision::kRefuse) continue;
    // What a person accepted stands as firm as odometry: no kernel, no refusal.
    const bool open = loop.loop.decision == LoopDecision::kAuto;
    factors.loop_of[i] = static_cast<int>(factors.graph.constraints.size());
    const Matrix6d information = pose_graph::g2o_information(loop_covariance(loop.loop, config));
    factors.graph.add({pose_graph::relative_pose_residual(loop.loop.T_from_to, information),
                       loop.from, loop.to, open,
                       open ? config.loop_robust_kernel : pose_graph::RobustKernel::kNone,
                       config.robust_kernel_size});
  }
}

void add_verticals(const DriveGraph& drive, const BackEndConfig& config,
                   pose_graph::FactorGraph& graph) {
  for (const Vertical& vertical : verticals(drive, config)) {
    graph.add({pose_graph::tilt_residual(vertical.up_base, vertical.stddev), vertical.node, -1,
               false, config.imu_robust_kernel, config.robust_kernel_size});
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

DriveFactors make_factors(const DriveGraph& drive, const BackEndConfig& config) {
  DriveFactors factors;
  factors.motion_of.assign(drive.nodes.size(), -1);
  factors.loop_of.assign(drive.loops.size(), -1);
  factors.horizontal_of.assign(drive.gnss.size(), -1);
  factors.altitude_of.assign(drive.gnss.size(), -1);
  for (const DriveNode& node : drive.nodes) {
    factors.graph.add_node(node.T_map_base, node.held);
  }
  const bool with_gnss = config.use_gnss && !config.georeference_only;
  const bool with_vertical =
      !drive.imu.empty() && (config.enable_imu_orientation || config.enable_imu_acceleration);
  add_priors(drive, config, with_gnss, with_vertical, factors.graph);
  add_odometry(drive, config, factors);
  add_verticals(drive, config, factors.graph);
  if (with_gnss && config.enable_imu_heading) add_headings(drive, config, factors.graph);
  add_floors(drive, config, factors.graph);
  if (config.use_loop_close) add_loops(drive, config, factors);
  if (with_gnss) add_gnss(drive, config, factors);
  factors.marked = marks(drive, factors);
  return factors;
}

}  // namespace lidar_mapping::back_end
