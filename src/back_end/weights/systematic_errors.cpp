// SPDX-License-Identifier: BSD-3-Clause
#include "weights/systematic_errors.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/antenna_fit.hpp"
#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "gnss/gnss_delay.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Standard deviation of the scale error of LiDAR odometry before positions show it. Measured on
/// simulated drives: -3e-5 to -1e-4.
constexpr double kScaleErrorStddev = 5e-5;
/// Prior that keeps a parameter at zero (s or m). Chosen far below what any drive determines.
constexpr double kFixedStddev = 1e-9;

enum Parameter { kScaleError, kDelay, kLeverArmX, kLeverArmY, kCount };
using ParameterVector = Eigen::Matrix<double, kCount, 1>;
using Displacements = Eigen::Matrix<double, 3, kCount>;

/// Normal equations of the parameters together with the poses.
class NormalEquations {
 public:
  NormalEquations(const pose_graph::FactorGraph& graph, const std::vector<bool>& used)
      : graph_(graph),
        pose_gradient_(Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(graph.states.size()))),
        mixed_(Eigen::MatrixXd::Zero(pose_gradient_.size(), kCount)) {
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (!used[i]) continue;
      const pose_graph::Constraint& c = graph.constraints[i];
      const pose_graph::LinearisedConstraint at = pose_graph::linearise(graph, c);
      // The poses are at the minimum of the cost with kernels.
      const Eigen::VectorXd weighted_residual =
          pose_graph::kernel_weight(c, at.residual) * at.residual;
      pose_gradient_.segment<6>(6 * c.first) += at.first.transpose() * weighted_residual;
      if (!c.is_binary()) continue;
      pose_gradient_.segment<6>(6 * c.second) += at.second.transpose() * weighted_residual;
    }
  }

  /// Adds the effect of the parameters on one constraint. A unit of each parameter acts like a
  /// displacement of the constraint's last node by its column of `displacements`, m in the node's
  /// axes.
  void add(int constraint, const Displacements& displacements) {
    const pose_graph::Constraint& c = graph_.constraints[constraint];
    const pose_graph::LinearisedConstraint at = pose_graph::linearise(graph_, c);
    const bool has_second = c.is_binary();
    const Eigen::MatrixXd effects =
        (has_second ? at.second : at.first).leftCols<3>() * displacements;
    gradient_ += effects.transpose() * at.residual;
    curvature_ += effects.transpose() * effects;
    mixed_.middleRows<6>(6 * c.first) += at.first.transpose() * effects;
    if (has_second) mixed_.middleRows<6>(6 * c.second) += at.second.transpose() * effects;
  }

  /// Newton step for parameters whose prior has mean zero and `stddev`.
  ParameterVector solution(pose_graph::BlockCholesky<6>& poses,
                           const ParameterVector& stddev) const {
    const Eigen::MatrixXd solved_mixed = poses.solve(mixed_);
    Eigen::Matrix<double, kCount, kCount> information =
        curvature_ - mixed_.transpose() * solved_mixed;
    information.diagonal() += stddev.cwiseAbs2().cwiseInverse();
    return -information.ldlt().solve(gradient_ - solved_mixed.transpose() * pose_gradient_);
  }

 private:
  const pose_graph::FactorGraph& graph_;
  Eigen::VectorXd pose_gradient_;
  ParameterVector gradient_ = ParameterVector::Zero();
  Eigen::Matrix<double, kCount, kCount> curvature_ = Eigen::Matrix<double, kCount, kCount>::Zero();
  Eigen::MatrixXd mixed_;
};

void add_scale_error(const DriveGraph& drive, const DriveFactors& factors,
                     NormalEquations& equations) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    if (factors.motion_of[i] < 0 || drive.nodes[i].doubtful) continue;
    const int node = static_cast<int>(i);
    const Eigen::Quaterniond R_node_previous =
        factors.graph.pose(node).rotation.conjugate() * factors.graph.pose(node - 1).rotation;
    // A longer measured motion has the effect of a node that is as much too far back.
    Displacements displacements = Displacements::Zero();
    displacements.col(kScaleError) = -(R_node_previous * motion_to(drive, i).translation);
    equations.add(factors.motion_of[i], displacements);
  }
}

void add_delay_and_lever_arm(const DriveGraph& drive, const DriveFactors& factors,
                             const std::vector<bool>& used, NormalEquations& equations) {
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    const int position = factors.horizontal_of[i];
    const auto segment = static_cast<std::size_t>(drive.segment_of(drive.gnss[i].node));
    if (!is_used(position, used) || !drive.gnss_delays[segment].is_corrected()) continue;
    Displacements displacements = Displacements::Zero();
    displacements.col(kDelay) = -antenna_velocity(drive, drive.gnss[i]);
    displacements.col(kLeverArmX) = Eigen::Vector3d::UnitX();
    displacements.col(kLeverArmY) = Eigen::Vector3d::UnitY();
    equations.add(position, displacements);
  }
}

/// Standard deviations of all parameters before the graph shows them.
ParameterVector prior_stddevs(const DriveGraph& drive) {
  double delay = kFixedStddev;
  double lever_arm = kFixedStddev;
  for (const GnssDelay& gnss_delay : drive.gnss_delays) {
    if (!gnss_delay.is_corrected()) continue;
    delay = std::max(delay, gnss_delay.sigma);
    lever_arm = AntennaFit::kMeasuredArm;
  }
  return {kScaleErrorStddev, delay, lever_arm, lever_arm};
}

}  // namespace

SystematicErrors estimate_systematic_errors(const DriveGraph& drive, const DriveFactors& factors,
                                            const std::vector<bool>& used, double scatter) {
  const std::unique_ptr<pose_graph::BlockCholesky<6>> poses =
      pose_graph::information_matrix(factors.graph, used);
  if (!poses->factorize()) return {};
  NormalEquations equations(factors.graph, used);
  add_scale_error(drive, factors, equations);
  add_delay_and_lever_arm(drive, factors, used, equations);
  // If all covariances are too large by one factor, the poses are the same, but the weights
  // relative to the priors of the parameters are not.
  const ParameterVector solution = equations.solution(*poses, prior_stddevs(drive) / scatter);
  return {solution(kScaleError), solution(kDelay), {solution(kLeverArmX), solution(kLeverArmY)}};
}

}  // namespace lidar_mapping::back_end
