// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/back_end/key_frame_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "drive/drive_results.hpp"
#include "factors/drive_factors.hpp"
#include "optimization.hpp"
#include "uncertainty/known_pose.hpp"

namespace lidar_mapping::back_end {

namespace {

PoseDeviation deviation_of(const Covariance6& covariance) {
  // Differences of large numbers may become negative by rounding.
  return {std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace())),
          std::sqrt(std::max(0.0, covariance.bottomRightCorner<3, 3>().trace()))};
}

/// Covariances of key frames and between neighbouring ones, with the first key frame known.
class Covariances {
 public:
  explicit Covariances(const DriveFactors& factors)
      : system_(pose_graph::information_matrix(factors.graph, factors.selected,
                                               neighbour_pairs(factors.graph))),
        inverse_(inverse_with_known_first(*system_)) {}

  /// False if the constraints do not determine all poses.
  bool are_known() const { return inverse_.has_value(); }

  Covariance6 of(int node) const { return between(node, node); }

  /// Covariance of the motion T_from_to.
  Covariance6 of_motion(int from, int to, const Pose& T_from_to) const {
    const Matrix6d adjoint_to_from = adjoint(T_from_to.inverse());
    const Matrix6d cross_term = adjoint_to_from * between(from, to);
    return adjoint_to_from * of(from) * adjoint_to_from.transpose() + of(to) - cross_term -
           cross_term.transpose();
  }

 private:
  static std::vector<std::pair<int, int>> neighbour_pairs(const pose_graph::FactorGraph& graph) {
    std::vector<std::pair<int, int>> pairs;
    for (int i = 1; i < static_cast<int>(graph.states.size()); ++i) pairs.emplace_back(i - 1, i);
    return pairs;
  }

  static std::optional<pose_graph::SelectedInverse> inverse_with_known_first(
      pose_graph::BlockCholesky<6>& system) {
    system.add_diagonal(0, kKnownInformation * Matrix6d::Identity());
    return system.selected_inverse();
  }

  Matrix6d between(int row, int column) const {
    return of_whole_angles(system_->block(*inverse_, row, column));
  }

  std::unique_ptr<pose_graph::BlockCholesky<6>> system_;
  std::optional<pose_graph::SelectedInverse> inverse_;
};

}  // namespace

std::vector<KeyFrameDeviation> key_frame_deviations(const OptimizationProblem& problem) {
  const DriveGraph& drive = problem.drive;
  std::vector<KeyFrameDeviation> result;
  if (drive.nodes.empty()) return result;
  const std::vector<int> parts = parts_of(drive);
  const DriveFactors factors = make_factors(drive, problem.config);
  const Covariances covariances(factors);
  const bool is_solvable = covariances.are_known();
  result.push_back({drive.nodes[0].index, parts[0], false, {0.0, 0.0}, {0.0, 0.0}});
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    const int node = static_cast<int>(i);
    const Pose motion = factors.graph.pose(node - 1).inverse() * factors.graph.pose(node);
    KeyFrameDeviation deviation{drive.nodes[i].index, parts[i], drive.nodes[i].doubtful, {}, {}};
    if (is_solvable && parts[i] == parts[0])
      deviation.from_first = deviation_of(covariances.of(node));
    if (is_solvable && parts[i] == parts[i - 1]) {
      deviation.from_previous = deviation_of(covariances.of_motion(node - 1, node, motion));
    }
    result.push_back(deviation);
  }
  return result;
}

}  // namespace lidar_mapping::back_end
