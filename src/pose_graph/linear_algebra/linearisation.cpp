// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/linearisation.hpp"

#include <array>

#include <ceres/loss_function.h>

namespace lidar_mapping::pose_graph {

LinearisedConstraint linearise(const FactorGraph& graph, const Constraint& constraint) {
  using Rows =
      Eigen::Matrix<double, Eigen::Dynamic, kPoseBlockSize, Eigen::RowMajor, kMaxResidualRows>;
  const int count = constraint.degrees_of_freedom();
  std::array<Rows, 2> jacobians = {Rows::Zero(count, kPoseBlockSize),
                                   Rows::Zero(count, kPoseBlockSize)};
  std::array<double*, 2> pointers = {jacobians[0].data(), jacobians[1].data()};
  std::array<double, kMaxResidualRows> residual{};
  evaluate(graph, constraint, residual.data(), pointers.data());
  return {Eigen::Map<const Eigen::VectorXd>(residual.data(), count), jacobians[0].leftCols<6>(),
          jacobians[1].leftCols<6>()};
}

double kernel_weight(const Constraint& constraint, const Eigen::VectorXd& residual) {
  const auto kernel = make_kernel(constraint.kernel, constraint.kernel_size);
  return loss_at(kernel.get(), residual.squaredNorm()).second;
}

std::unique_ptr<BlockCholesky<6>> information_matrix(
    const FactorGraph& graph, const std::vector<bool>& selected,
    const std::vector<std::pair<int, int>>& more_pairs) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const Constraint& constraint = graph.constraints[i];
    if (selected[i] && constraint.is_binary()) {
      pairs.emplace_back(constraint.first, constraint.second);
    }
  }
  pairs.insert(pairs.end(), more_pairs.begin(), more_pairs.end());
  auto system = std::make_unique<BlockCholesky<6>>(static_cast<int>(graph.states.size()), pairs);
  system->set_zero();
  std::size_t pair = 0;
  for (std::size_t i = 0; i < selected.size(); ++i) {
    if (!selected[i]) continue;
    const Constraint& constraint = graph.constraints[i];
    const auto [residual, first, second] = linearise(graph, constraint);
    const double weight = constraint.doubtful ? kernel_weight(constraint, residual) : 1.0;
    system->add_diagonal(constraint.first, weight * first.transpose() * first);
    if (!constraint.is_binary()) continue;
    system->add_diagonal(constraint.second, weight * second.transpose() * second);
    system->add_pair(pair++, weight * first.transpose() * second);
  }
  return system;
}

}  // namespace lidar_mapping::pose_graph
