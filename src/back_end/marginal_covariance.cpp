#include "lidar_mapping/back_end/marginal_covariance.hpp"

#include <algorithm>
#include <cmath>

#include "drive_factors.hpp"
#include "linearisation.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {

std::optional<Covariance6> marginal_covariance(const OptimizationProblem& problem,
                                               KeyFrameIndex index) {
  const auto& nodes = problem.drive.nodes;
  const auto found = std::find_if(nodes.begin(), nodes.end(),
                                  [&](const DriveNode& node) { return node.index == index; });
  if (found == nodes.end()) return std::nullopt;
  const auto row = 6 * static_cast<Eigen::Index>(found - nodes.begin());
  const DriveFactors factors = make_factors(problem.drive, problem.config);
  const std::unique_ptr<BlockCholesky<6>> system =
      information_matrix(factors.graph, factors.marked);
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
  const std::unique_ptr<BlockCholesky<6>> system = information_matrix(graph, marked);
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
