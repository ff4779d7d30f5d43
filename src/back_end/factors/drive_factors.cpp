// SPDX-License-Identifier: BSD-3-Clause
#include "factors/drive_factors.hpp"

#include <utility>

#include "factors/floor_factors.hpp"
#include "factors/weak_prior.hpp"
#include "gnss/gnss_factors.hpp"
#include "imu/vertical.hpp"
#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {

namespace {

// Prior of the first node of a segment. It determines the pose of the map if no other constraint
// does. With GNSS it only determines the directions that positions cannot observe, such as the roll
// on a straight road. Chosen: strong is far below the errors of a motion; weak is as good as
// unknown (weak_prior.hpp), but the tilt of a vehicle on a road is small (3 degrees).
constexpr double kStrongStddev_m = 1e-3;
constexpr double kStrongStddev_rad = 1e-4;
constexpr double kWeakTiltStddev_rad = 0.05;

/// Position and heading, and the tilt, each with a strong or a weak prior.
Covariance6 prior_covariance(const Pose& T_map_base, bool strong_position, bool strong_tilt) {
  const Eigen::Vector3d up_base = T_map_base.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double tilt = strong_tilt ? kStrongStddev_rad : kWeakTiltStddev_rad;
  const double heading = strong_position ? kStrongStddev_rad : kWeakHeadingStddev_rad;
  Covariance6 covariance =
      diagonal_covariance(strong_position ? kStrongStddev_m : kWeakStddev_m, tilt);
  covariance.bottomRightCorner<3, 3>() +=
      (heading * heading - tilt * tilt) * up_base * up_base.transpose();
  return covariance;
}

/// As configured: the squares of x y z roll pitch yaw.
Covariance6 configured_covariance(const BackEndConfig& config) {
  return Eigen::Map<const Vector6d>(config.fix_first_node_stddev.data()).cwiseAbs2().asDiagonal();
}

void add_priors(const DriveGraph& drive, const BackEndConfig& config, bool with_gnss,
                bool with_vertical, pose_graph::FactorGraph& graph) {
  const std::vector<int> connected = connected_segments(drive, true);
  for (std::size_t segment = 0; segment < drive.segment_starts.size(); ++segment) {
    const int node = drive.segment_starts[segment];
    const Pose& pose = segment == 0 ? drive.T_map_first : drive.nodes[node].T_map_base;
    // A segment that loops connect to another one needs no prior. A weak one keeps the system
    // solvable if all its loops are refused.
    const bool isolated = connected[segment] == static_cast<int>(segment);
    const bool strong = isolated && !(with_gnss && drive.in_enu[segment]);
    const Covariance6 covariance = segment == 0 && config.fix_first_node
                                       ? configured_covariance(config)
                                       : prior_covariance(pose, strong, strong && !with_vertical);
    graph.add({pose_graph::prior_residual(pose, pose_graph::g2o_information(covariance)), node});
  }
}

// A doubtful step connects its key frames if nothing else does. Its kernel reduces its weight if
// other constraints contradict it by more than the error that is expected of it.
constexpr pose_graph::RobustKernel kDoubtfulKernel = pose_graph::RobustKernel::kCauchy;
constexpr double kDoubtfulKernelSize = 1.0;  // of the expected error, by definition of the kernel

void add_odometry(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    if (!drive.nodes[i].connected) continue;
    const int to = static_cast<int>(i);
    const Matrix6d information =
        pose_graph::g2o_information(motion_covariance_to(drive, i, config));
    pose_graph::Constraint motion{
        pose_graph::relative_pose_residual(motion_to(drive, i), information), to - 1, to};
    motion.doubtful = drive.nodes[i].doubtful;
    const auto kernel = motion.doubtful ? kDoubtfulKernel : config.odometry_robust_kernel;
    const double size = motion.doubtful ? kDoubtfulKernelSize : config.robust_kernel_size;
    factors.motion_of[i] = factors.graph.add(std::move(motion), kernel, size);
  }
}

void add_loops(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    const DriveLoop& loop = drive.loops[i];
    if (loop.loop.decision == LoopDecision::kRefuse) continue;
    const Matrix6d information = pose_graph::g2o_information(loop_covariance(loop.loop, config));
    pose_graph::Constraint constraint{
        pose_graph::relative_pose_residual(loop.loop.T_from_to, information), loop.from, loop.to};
    // A loop that a person accepted has no kernel and is never refused, like odometry.
    constraint.switchable = loop.loop.decision == LoopDecision::kAuto;
    if (constraint.switchable) constraint.kernel = config.loop_robust_kernel;
    constraint.kernel_size = config.robust_kernel_size;
    factors.loop_of[i] = factors.graph.add(std::move(constraint));
  }
}

void add_verticals(const DriveGraph& drive, const BackEndConfig& config,
                   pose_graph::FactorGraph& graph) {
  for (const Vertical& vertical : verticals(drive, config)) {
    graph.add({pose_graph::tilt_residual(vertical.up_base, vertical.stddev), vertical.node},
              config.imu_robust_kernel, config.robust_kernel_size);
  }
}

/// Constraints that were used so far or were never evaluated.
std::vector<bool> selected_constraints(const DriveGraph& drive, const DriveFactors& factors) {
  std::vector<bool> selected(factors.graph.constraints.size(), true);
  const auto select = [&](int constraint, bool used, bool evaluated) {
    if (constraint >= 0) selected[constraint] = used || !evaluated;
  };
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    select(factors.loop_of[i], drive.loops[i].used, drive.loops[i].evaluated);
  }
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    select(factors.horizontal_of[i], drive.gnss[i].horizontal_used, drive.gnss[i].evaluated);
    select(factors.altitude_of[i], drive.gnss[i].altitude_used, drive.gnss[i].evaluated);
  }
  return selected;
}

}  // namespace

DriveFactors make_factors(const DriveGraph& drive, const BackEndConfig& config) {
  DriveFactors factors;
  factors.motion_of.assign(drive.nodes.size(), -1);
  factors.loop_of.assign(drive.loops.size(), -1);
  factors.horizontal_of.assign(drive.gnss.size(), -1);
  factors.altitude_of.assign(drive.gnss.size(), -1);
  for (const DriveNode& node : drive.nodes) {
    factors.graph.add_node(node.T_map_base, node.fixed);
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
  factors.selected = selected_constraints(drive, factors);
  return factors;
}

}  // namespace lidar_mapping::back_end
