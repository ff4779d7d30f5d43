// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pose_graph/residuals.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"
#include "lidar_mapping/pose_graph/tangent.hpp"

namespace lidar_mapping::pose_graph {

/// Rows that a residual may have: as many as a pose has degrees of freedom.
constexpr int kMaxResidualRows = 6;

/// A whitened residual of 1 to kMostRows rows on one or two nodes.
struct Constraint {
  CostPtr residual;
  int first = 0;
  int second = -1;                            ///< -1: a constraint on one node
  bool switchable = false;                    ///< may be refused when the others contradict it
  RobustKernel kernel = RobustKernel::kNone;  ///< where it is believed
  double kernel_size = 1.0;                   ///< standard deviations
  /// May be wrong by far more than it says: has the least weight while others are judged.
  bool doubtful = false;

  int degrees_of_freedom() const { return residual->num_residuals(); }
};

/// Nodes with their present states and what ties them. The core of the back end: it knows nothing
/// of odometry, loops or GNSS.
struct FactorGraph {
  bool planar = false;
  std::vector<StateBlock> states;
  std::vector<bool> fixed;  ///< nodes that do not move
  std::vector<Constraint> constraints;

  int add_node(const Pose& pose, bool is_fixed = false);
  /// Throws InputError unless the constraint has 1 to kMostRows rows, a block for each of its nodes
  /// in the size of this graph's states, and nodes that are there already.
  void add(Constraint constraint);
  Pose pose(int node) const;
  void set_pose(int node, const Pose& pose);
};

/// Squared whitened norm of a constraint at the present states.
double chi2(const FactorGraph& graph, const Constraint& constraint);
/// Sum over the constraints that `used` marks: g2o's chi2, without kernels.
double total_chi2(const FactorGraph& graph, const std::vector<bool>& used);

/// How a minimisation is run; the defaults are a Gauss-Newton that falls back on damping.
struct MinimizerSettings {
  int max_iterations = 50;
  /// Of the trust region. From 1e10 on it does not bind, and undamped steps are tried first.
  double initial_radius = 1e10;
  /// Relative to the cost: ends when further steps can be expected to gain less than this.
  double tolerance = 1e-7;
};

struct MinimizerSummary {
  double initial_cost = 0.0;  ///< chi2, with kernels where there are
  double final_cost = 0.0;
  int iterations = 0;
  bool usable = false;  ///< false where the solver failed; the states are then as before
  std::string message;
};

/// The loss of a constraint during one minimisation; null for least squares. The caller owns it.
using LossOf = std::function<ceres::LossFunction*(const Constraint&)>;

/// Moves the nodes to the least sum over the `used` constraints: by the package's own Gauss-Newton
/// (gauss_newton.hpp) where the trust region does not bind; where that fails to lower the cost, or
/// where damping is asked for, by Levenberg-Marquardt in Ceres. Both factorise by a sparse
/// Cholesky.
MinimizerSummary minimize(FactorGraph& graph, const std::vector<bool>& used, const LossOf& loss_of,
                          const MinimizerSettings& settings);

}  // namespace lidar_mapping::pose_graph
