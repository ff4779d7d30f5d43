#include "lidar_mapping/back_end/marginal_covariance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/back_end/block_cholesky.hpp"
#include "lidar_mapping/back_end/drive_factors.hpp"
#include "lidar_mapping/back_end/optimization.hpp"

namespace lidar_mapping::back_end {

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, kPoseBlockSize, Eigen::RowMajor, 6>;

/// Derivatives of a constraint with respect to its nodes' tangents.
std::array<Eigen::MatrixXd, 2> derivatives(const FactorGraph& graph, const Constraint& constraint) {
  const bool pair = constraint.second >= 0;
  const auto block = [&](int node) { return graph.states[static_cast<std::size_t>(node)].data(); };
  const std::array<const double*, 2> blocks = {block(constraint.first),
                                               block(pair ? constraint.second : constraint.first)};
  const int count = constraint.degrees_of_freedom();
  std::array<Rows, 2> jacobians = {Rows::Zero(count, kPoseBlockSize),
                                   Rows::Zero(count, kPoseBlockSize)};
  std::array<double*, 2> pointers = {jacobians[0].data(), jacobians[1].data()};
  std::array<double, 6> residual{};
  constraint.residual->Evaluate(blocks.data(), residual.data(), pointers.data());
  return {jacobians[0].leftCols<6>(), jacobians[1].leftCols<6>()};
}

/// The information matrix of all marked constraints.
std::unique_ptr<BlockCholesky<6>> information(const FactorGraph& graph,
                                              const std::vector<bool>& marked) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const Constraint& constraint = graph.constraints[i];
    if (marked[i] && constraint.second >= 0) {
      pairs.emplace_back(constraint.first, constraint.second);
    }
  }
  auto system = std::make_unique<BlockCholesky<6>>(static_cast<int>(graph.states.size()), pairs);
  system->set_zero();
  std::size_t pair = 0;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (!marked[i]) continue;
    const Constraint& constraint = graph.constraints[i];
    const auto [first, second] = derivatives(graph, constraint);
    system->add_diagonal(constraint.first, first.transpose() * first);
    if (constraint.second < 0) continue;
    system->add_diagonal(constraint.second, second.transpose() * second);
    system->add_pair(pair++, first.transpose() * second);
  }
  return system;
}

}  // namespace

std::optional<Covariance6> marginal_covariance(const OptimizationProblem& problem,
                                               KeyFrameIndex index) {
  const auto& nodes = problem.drive.nodes;
  const auto found = std::find_if(nodes.begin(), nodes.end(),
                                  [&](const DriveNode& node) { return node.index == index; });
  if (found == nodes.end()) return std::nullopt;
  const auto row = 6 * static_cast<Eigen::Index>(found - nodes.begin());
  const DriveFactors factors = make_factors(problem.drive, problem.config);
  const std::unique_ptr<BlockCholesky<6>> system = information(factors.graph, factors.marked);
  if (!system->factorize()) return std::nullopt;
  Eigen::MatrixXd unit =
      Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(factors.graph.states.size()), 6);
  unit.middleRows<6>(row).setIdentity();
  const Matrix6d covariance = system->solve(unit).middleRows<6>(row);
  // The tangent has half angles.
  const Vector6d angles = (Vector6d() << 1.0, 1.0, 1.0, 2.0, 2.0, 2.0).finished();
  return Covariance6(angles.asDiagonal() * (0.5 * (covariance + covariance.transpose())) *
                     angles.asDiagonal());
}

double least_eigenvalue(const FactorGraph& graph, const std::vector<bool>& marked) {
  constexpr int kIterations = 30;
  const std::unique_ptr<BlockCholesky<6>> system = information(graph, marked);
  if (!system->factorize()) return 0.0;
  const auto size = 6 * static_cast<Eigen::Index>(graph.states.size());
  // Any start will do that is not across the wanted vector.
  Eigen::VectorXd vector = Eigen::VectorXd::LinSpaced(size, 1.0, 2.0).normalized();
  double largest_of_inverse = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    vector = system->solve(vector);
    largest_of_inverse = vector.norm();
    if (!std::isfinite(largest_of_inverse) || largest_of_inverse == 0.0) return 0.0;
    vector /= largest_of_inverse;
  }
  return 1.0 / largest_of_inverse;
}

}  // namespace lidar_mapping::back_end
