// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/back_end/relative_covariance.hpp"

#include <algorithm>

#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "factors/drive_factors.hpp"
#include "optimization.hpp"
#include "uncertainty/known_pose.hpp"

namespace lidar_mapping::back_end {

namespace {

// Of each key frame, so that all are determined: one kilometre. Chosen: farther than drives err.
constexpr double kUnknownInformation = 1e-6;

/// The constraints of odometry alone.
std::vector<bool> odometry_constraints(const DriveFactors& factors) {
  std::vector<bool> selected(factors.selected.size(), false);
  for (const int motion : factors.motion_of) {
    if (motion >= 0) selected[motion] = true;
  }
  return selected;
}

}  // namespace

RelativeCovariance::RelativeCovariance(const OptimizationProblem& problem, KeyFrameIndex from,
                                       Given given) {
  for (const DriveNode& node : problem.drive.nodes) key_frames_.push_back(node.index);
  const DriveFactors factors = make_factors(problem.drive, problem.config);
  states_ = static_cast<int>(factors.graph.states.size());
  system_ = pose_graph::information_matrix(
      factors.graph, given == Given::kAll ? factors.selected : odometry_constraints(factors));
  for (int i = 0; i < states_; ++i) {
    system_->add_diagonal(i, kUnknownInformation * Matrix6d::Identity());
  }
  if (const auto row = row_of(from))
    system_->add_diagonal(*row, kKnownInformation * Matrix6d::Identity());
  is_solvable_ = system_->factorize();
}

std::optional<Covariance6> RelativeCovariance::of(KeyFrameIndex to) const {
  const auto row = row_of(to);
  if (!row || !is_solvable_) return std::nullopt;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(Eigen::Index{6} * states_, 6);
  unit.middleRows<6>(Eigen::Index{6} * *row).setIdentity();
  const Matrix6d covariance = system_->solve(unit).middleRows<6>(Eigen::Index{6} * *row);
  return of_whole_angles(0.5 * (covariance + covariance.transpose()));
}

std::optional<int> RelativeCovariance::row_of(KeyFrameIndex index) const {
  const auto found = std::find(key_frames_.begin(), key_frames_.end(), index);
  if (found == key_frames_.end()) return std::nullopt;
  return static_cast<int>(found - key_frames_.begin());
}

}  // namespace lidar_mapping::back_end
