// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/least_eigenvalue.hpp"

#include <cmath>

#include "lidar_mapping/pose_graph/linearisation.hpp"

namespace lidar_mapping::pose_graph {

double least_eigenvalue(const FactorGraph& graph, const std::vector<bool>& selected) {
  // Of the power iteration. Chosen: too few give too large a value where two eigenvalues are close.
  constexpr int kIterations = 30;
  const std::unique_ptr<BlockCholesky<6>> system = information_matrix(graph, selected);
  if (!system->factorize()) return 0.0;
  const auto size = 6 * static_cast<Eigen::Index>(graph.states.size());
  // Any start vector that is not orthogonal to the eigenvector will do.
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

}  // namespace lidar_mapping::pose_graph
