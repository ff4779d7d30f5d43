#include "linearisation.hpp"

#include <array>

namespace lidar_mapping::back_end {

Linearised linearised(const FactorGraph& graph, const Constraint& constraint) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, kPoseBlockSize, Eigen::RowMajor, kMostRows>;
  const bool pair = constraint.second >= 0;
  const auto block = [&](int node) { return graph.states[static_cast<std::size_t>(node)].data(); };
  const std::array<const double*, 2> blocks = {block(constraint.first),
                                               block(pair ? constraint.second : constraint.first)};
  const int count = constraint.degrees_of_freedom();
  std::array<Rows, 2> jacobians = {Rows::Zero(count, kPoseBlockSize),
                                   Rows::Zero(count, kPoseBlockSize)};
  std::array<double*, 2> pointers = {jacobians[0].data(), jacobians[1].data()};
  std::array<double, kMostRows> residual{};
  constraint.residual->Evaluate(blocks.data(), residual.data(), pointers.data());
  return {Eigen::Map<const Eigen::VectorXd>(residual.data(), count), jacobians[0].leftCols<6>(),
          jacobians[1].leftCols<6>()};
}

std::unique_ptr<BlockCholesky<6>> information_matrix(const FactorGraph& graph,
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
    const auto [residual, first, second] = linearised(graph, constraint);
    system->add_diagonal(constraint.first, first.transpose() * first);
    if (constraint.second < 0) continue;
    system->add_diagonal(constraint.second, second.transpose() * second);
    system->add_pair(pair++, first.transpose() * second);
  }
  return system;
}

}  // namespace lidar_mapping::back_end
