// SPDX-License-Identifier: BSD-3-Clause
#include "shared_errors.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/antenna_fit.hpp"
#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "gnss_delay.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Of the scale of LiDAR odometry before positions show it.
constexpr double kStretchStddev = 5e-5;
/// Keeps an unknown out that nothing may change.
constexpr double kFixed = 1e-9;

enum Unknown { kStretch, kDelay, kArmX, kArmY, kCount };
using UnknownVector = Eigen::Matrix<double, kCount, 1>;
using Shifts = Eigen::Matrix<double, 3, kCount>;

/// Normal equations of the unknowns beside the poses.
class SharedEquations {
 public:
  SharedEquations(const pose_graph::FactorGraph& graph, const std::vector<bool>& used)
      : graph_(graph),
        pose_gradient_(Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(graph.states.size()))),
        mixed_(Eigen::MatrixXd::Zero(pose_gradient_.size(), kCount)) {
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (!used[i]) continue;
      const pose_graph::Constraint& c = graph.constraints[i];
      const pose_graph::Linearised at = pose_graph::linearised(graph, c);
      // The poses are at a minimum with kernels.
      const Eigen::VectorXd pull = pose_graph::kernel_slope(c, at.residual) * at.residual;
      pose_gradient_.segment<6>(6 * c.first) += at.first.transpose() * pull;
      if (c.second < 0) continue;
      pose_gradient_.segment<6>(6 * c.second) += at.second.transpose() * pull;
    }
  }

  /// A unit of each unknown has the effect that its column of `shifts` (m) has on the constraint's
  /// last node, in the node's axes.
  void add(int constraint, const Shifts& shifts) {
    const pose_graph::Constraint& c = graph_.constraints[static_cast<std::size_t>(constraint)];
    const pose_graph::Linearised at = pose_graph::linearised(graph_, c);
    const bool pair = c.second >= 0;
    const Eigen::MatrixXd effects = (pair ? at.second : at.first).leftCols<3>() * shifts;
    gradient_ += effects.transpose() * at.residual;
    curvature_ += effects.transpose() * effects;
    mixed_.middleRows<6>(6 * c.first) += at.first.transpose() * effects;
    if (pair) mixed_.middleRows<6>(6 * c.second) += at.second.transpose() * effects;
  }

  /// Newton's step for unknowns that are near zero, by `stddev`.
  UnknownVector solution(pose_graph::BlockCholesky<6>& poses, const UnknownVector& stddev) const {
    const Eigen::MatrixXd by_poses = poses.solve(mixed_);
    Eigen::Matrix<double, kCount, kCount> information = curvature_ - mixed_.transpose() * by_poses;
    information.diagonal() += stddev.cwiseAbs2().cwiseInverse();
    return -information.ldlt().solve(gradient_ - by_poses.transpose() * pose_gradient_);
  }

 private:
  const pose_graph::FactorGraph& graph_;
  Eigen::VectorXd pose_gradient_;
  UnknownVector gradient_ = UnknownVector::Zero();
  Eigen::Matrix<double, kCount, kCount> curvature_ = Eigen::Matrix<double, kCount, kCount>::Zero();
  Eigen::MatrixXd mixed_;
};

void add_stretch(const DriveGraph& drive, const DriveFactors& factors, SharedEquations& equations) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    if (factors.motion_of[i] < 0 || drive.nodes[i].doubtful) continue;
    const int node = static_cast<int>(i);
    const Eigen::Quaterniond R_node_previous =
        factors.graph.pose(node).rotation.conjugate() * factors.graph.pose(node - 1).rotation;
    // A longer motion was measured: as if the node lay as much behind.
    Shifts shifts = Shifts::Zero();
    shifts.col(kStretch) = -(R_node_previous * motion_to(drive, i).translation);
    equations.add(factors.motion_of[i], shifts);
  }
}

void add_delay_and_arm(const DriveGraph& drive, const DriveFactors& factors,
                       const std::vector<bool>& used, SharedEquations& equations) {
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    const int position = factors.horizontal_of[i];
    const auto segment = static_cast<std::size_t>(drive.segment_of(drive.gnss[i].node));
    if (position < 0 || !used[static_cast<std::size_t>(position)]) continue;
    if (!drive.gnss_delays[segment].is_corrected()) continue;
    Shifts shifts = Shifts::Zero();
    shifts.col(kDelay) = -antenna_velocity(drive, drive.gnss[i]);
    shifts.col(kArmX) = Eigen::Vector3d::UnitX();
    shifts.col(kArmY) = Eigen::Vector3d::UnitY();
    equations.add(position, shifts);
  }
}

/// Of all unknowns before the graph shows them.
UnknownVector stddevs(const DriveGraph& drive) {
  double delay = kFixed;
  double arm = kFixed;
  for (const GnssDelay& found : drive.gnss_delays) {
    if (!found.is_corrected()) continue;
    delay = std::max(delay, found.sigma);
    arm = AntennaFit::kMeasuredArm;
  }
  return {kStretchStddev, delay, arm, arm};
}

}  // namespace

SharedErrors find_shared_errors(const DriveGraph& drive, const DriveFactors& factors,
                                const std::vector<bool>& used, double scatter) {
  const std::unique_ptr<pose_graph::BlockCholesky<6>> poses =
      pose_graph::information_matrix(factors.graph, used);
  if (!poses->factorize()) return {};
  SharedEquations equations(factors.graph, used);
  add_stretch(drive, factors, equations);
  add_delay_and_arm(drive, factors, used, equations);
  // Covariances that are all too large by one factor leave the poses as they are, but not what they
  // are worth beside an unknown's own.
  const UnknownVector solution = equations.solution(*poses, stddevs(drive) / scatter);
  return {solution(kStretch), solution(kDelay), {solution(kArmX), solution(kArmY)}};
}

}  // namespace lidar_mapping::back_end
