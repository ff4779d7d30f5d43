// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/evaluation/lever_arm.hpp"

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::evaluation {

namespace {

// Chosen: steps between motion and lever arm, each of which solves for one with the other known.
constexpr int kIterations = 30;
/// Variance of the direction cosines over the drive below which a component is not determined.
/// Chosen: 2 degrees of scatter, with which an error of 1 cm in the poses is one of 0.3 m.
constexpr double kLeastTurning = 1e-3;

/// The mean of R_i^T (t_i - p_i).
Eigen::Vector3d mean_offset(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    sum +=
        pair.estimate.rotation.conjugate() * (pair.truth.translation - pair.estimate.translation);
  }
  return sum / static_cast<double>(pairs.size());
}

/// The offset l for which t_i - p_i - R_i l varies least: a motion takes what does not vary. In
/// centred values it solves (1 - M^T M) l = mean(R_i^T d_i) - M^T mean(d_i) with M the mean of R_i.
Eigen::Vector3d least_varying_offset(const std::vector<PosePair>& pairs) {
  Eigen::Matrix3d mean_rotation = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean_difference = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    mean_rotation += pair.estimate.rotation_matrix();
    mean_difference += pair.truth.translation - pair.estimate.translation;
  }
  mean_rotation /= static_cast<double>(pairs.size());
  mean_difference /= static_cast<double>(pairs.size());
  const Eigen::Matrix3d turning =
      Eigen::Matrix3d::Identity() - mean_rotation.transpose() * mean_rotation;
  const Eigen::Vector3d right = mean_offset(pairs) - mean_rotation.transpose() * mean_difference;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(turning);
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = solver.eigenvectors().col(i);
    if (solver.eigenvalues()[i] < kLeastTurning) continue;
    offset += axis * axis.dot(right) / solver.eigenvalues()[i];
  }
  return offset;
}

}  // namespace

std::vector<PosePair> moved_on_vehicle(std::vector<PosePair> pairs, const Pose& T_estimate_truth) {
  for (PosePair& pair : pairs) pair.estimate = pair.estimate * T_estimate_truth;
  return pairs;
}

std::optional<Eigen::Vector3d> estimated_lever_arm(const std::vector<PosePair>& pairs, bool align) {
  if (pairs.size() < 3) return std::nullopt;
  if (!align) return mean_offset(pairs);
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  for (int i = 0; i < kIterations; ++i) {
    const Pose motion =
        rigid_alignment(moved_on_vehicle(pairs, {Eigen::Quaterniond::Identity(), lever_arm}));
    lever_arm = least_varying_offset(aligned(pairs, motion));
  }
  return lever_arm;
}

Eigen::Quaterniond estimated_turn(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) throw InputError("there are no common poses");
  // The mean rotation is the eigenvector of the largest eigenvalue (Markley et al. 2007).
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const PosePair& pair : pairs) {
    const Eigen::Quaterniond turn = pair.estimate.rotation.conjugate() * pair.truth.rotation;
    sum += turn.coeffs() * turn.coeffs().transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  return Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3))).normalized();
}

}  // namespace lidar_mapping::evaluation
