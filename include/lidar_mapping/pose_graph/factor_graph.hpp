// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/pose_graph/residuals.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"
#include "lidar_mapping/pose_graph/tangent.hpp"

namespace lidar_mapping::pose_graph {

/// Largest number of rows of a residual: by geometry, the degrees of freedom of a pose.
constexpr int kMaxResidualRows = 6;

/// Stands for a node that is not there. By definition: nodes are numbered from 0.
constexpr int kNoNode = -1;

/// A constraint (factor) of the graph: a whitened residual of 1 to kMaxResidualRows rows on one or
/// two nodes.
struct Constraint {
  CostPtr residual;                           ///< residual with its derivatives, residuals.hpp
  int first = 0;                              ///< number of the first node
  int second = kNoNode;                       ///< number of the second node, or kNoNode
  bool switchable = false;                    ///< may be refused if the others contradict it
  RobustKernel kernel = RobustKernel::kNone;  ///< kernel while it is used
  double kernel_size = 1.0;                   ///< scale of the kernel, standard deviations
  /// Its error may be much larger than its covariance allows. It has the least weight while the
  /// switchable constraints are evaluated.
  bool doubtful = false;

  /// Whether it is on two nodes.
  bool is_binary() const { return second >= 0; }
  /// Number of rows of the residual.
  int degrees_of_freedom() const { return residual->num_residuals(); }
};

/// Factor graph (Dellaert & Kaess 2017): nodes with their current states, and the constraints
/// between them. It is independent of where the constraints come from.
struct FactorGraph {
  bool planar = false;                  ///< the states are x y yaw instead of 3D poses
  std::vector<StateBlock> states;       ///< current state of each node
  std::vector<bool> fixed;              ///< nodes whose states are constant
  std::vector<Constraint> constraints;  ///< all constraints, used or not

  /// Adds a node with a start pose and returns its number. A fixed node keeps its state.
  int add_node(const Pose& pose, bool is_fixed = false);
  /// Adds a constraint and returns its number. Throws InputError unless its residual has 1 to
  /// kMaxResidualRows rows and one parameter block per node in the size of this graph's states, and
  /// the nodes exist already.
  int add(Constraint constraint);
  /// The same under a kernel of this size (standard deviations).
  int add(Constraint constraint, RobustKernel kernel, double kernel_size);
  /// Current pose of a node.
  Pose pose(int node) const;
  /// Replaces the state of a node; planar graphs take x, y and yaw of the pose.
  void set_pose(int node, const Pose& pose);
};

/// Evaluates the whitened residual of a constraint at the current states. `jacobians`, null if they
/// are not wanted, are those for the first and the second node in the layout of Ceres.
void evaluate(const FactorGraph& graph, const Constraint& constraint, double* residual,
              double** jacobians);
/// Squared norm of a whitened residual at the current states, without kernel.
double chi2(const FactorGraph& graph, const Constraint& constraint);
/// Sum of chi2() over the constraints with `used` true, as g2o reports it.
double total_chi2(const FactorGraph& graph, const std::vector<bool>& used);

/// How the normal equations of a minimisation are solved.
struct LinearSolver {
  /// Piece by piece, as minimize_condensed() does it, instead of in one factorisation.
  bool condensed = false;
  int threads = 0;  ///< of the condensed solver; 0: all cores. The result does not depend on it
};

/// Settings of a minimisation. With the defaults, Gauss-Newton steps are tried first and damped
/// steps only if these fail.
struct MinimizerSettings {
  int max_iterations = 50;  ///< limit for the number of steps
  /// Initial radius of the trust region of damped steps, in the units of the states. Without it
  /// undamped steps are tried first.
  std::optional<double> initial_radius;
  /// The minimisation ends if the next steps are expected to lower the cost by less than this
  /// fraction.
  double tolerance = 1e-7;
  LinearSolver solver;  ///< how each step is computed
};

/// Result of a minimisation.
struct MinimizerSummary {
  double initial_cost = 0.0;  ///< chi2 at the start, with the losses
  double final_cost = 0.0;    ///< chi2 at the end, with the losses
  int iterations = 0;         ///< number of steps, also of refused ones
  bool usable = false;        ///< false if the solver failed; the states are then unchanged
  std::string message;        ///< why the minimisation ended
};

/// Gives the loss function of a constraint during one minimisation; null for least squares. The
/// caller keeps the ownership.
using LossOf = std::function<ceres::LossFunction*(const Constraint&)>;

/// Minimises the cost of the constraints with `used` true and updates the states. Gauss-Newton
/// steps (gauss_newton.hpp) are used unless the settings give a trust region. If these fail, or
/// with a trust region, Ceres solves by Levenberg-Marquardt (Nocedal & Wright 2006). Both use a
/// sparse Cholesky factorisation. With `settings.solver.condensed`, minimize_condensed() does it
/// all.
MinimizerSummary minimize(FactorGraph& graph, const std::vector<bool>& used, const LossOf& loss_of,
                          const MinimizerSettings& settings);

}  // namespace lidar_mapping::pose_graph
