// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/evaluation/association.hpp"

#include <algorithm>

#include <Eigen/Geometry>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::evaluation {

namespace {

std::vector<PosePair> associate_by_line(const Trajectory& truth, const Trajectory& estimate) {
  if (truth.poses.size() != estimate.poses.size()) {
    throw InputError("trajectories without stamps need equal lengths: the truth has " +
                     std::to_string(truth.poses.size()) + " poses, the estimate " +
                     std::to_string(estimate.poses.size()) + "; use TUM files");
  }
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    pairs.push_back({estimate.poses[i].stamp, truth.poses[i].pose, estimate.poses[i].pose});
  }
  return pairs;
}

/// Umeyama's matrix: rotation times scale, and translation.
Eigen::Matrix4d umeyama(const std::vector<PosePair>& pairs, bool with_scale) {
  if (pairs.size() < 3) {
    throw InputError("an alignment needs at least 3 common poses, there are " +
                     std::to_string(pairs.size()));
  }
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd truth(3, count);
  Eigen::Matrix3Xd estimate(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    truth.col(i) = pairs[i].truth.translation;
    estimate.col(i) = pairs[i].estimate.translation;
  }
  return Eigen::umeyama(estimate, truth, with_scale);
}

/// Whether the positions are not all the same.
bool moves(const std::vector<PosePair>& pairs, Pose PosePair::*which) {
  return std::any_of(pairs.begin(), pairs.end(), [&](const PosePair& pair) {
    return (pair.*which).translation != (pairs.front().*which).translation;
  });
}

}  // namespace

std::vector<PosePair> associate(const Trajectory& truth, const Trajectory& estimate,
                                double largest_gap_s) {
  if (!truth.has_stamps || !estimate.has_stamps) return associate_by_line(truth, estimate);
  std::vector<PosePair> pairs;
  for (const StampedPose& entry : estimate.poses) {
    const auto pose = pose_at(entry.stamp, truth, largest_gap_s);
    if (pose) pairs.push_back({entry.stamp, *pose, entry.pose});
  }
  return pairs;
}

Pose rigid_alignment(const std::vector<PosePair>& pairs) {
  return Pose::from_matrix(umeyama(pairs, false));
}

SimilarityAlignment similarity_alignment(const std::vector<PosePair>& pairs) {
  Eigen::Matrix4d matrix = umeyama(pairs, true);
  if (!moves(pairs, &PosePair::truth) || !moves(pairs, &PosePair::estimate)) {
    throw InputError("a scale needs a truth and an estimate that move");
  }
  const double scale = matrix.topLeftCorner<3, 3>().col(0).norm();
  matrix.topLeftCorner<3, 3>() /= scale;
  return {Pose::from_matrix(matrix), scale};
}

std::vector<PosePair> scaled(std::vector<PosePair> pairs, double scale) {
  for (PosePair& pair : pairs) pair.estimate.translation *= scale;
  return pairs;
}

std::vector<PosePair> aligned(std::vector<PosePair> pairs, const Pose& T_truth_estimate) {
  for (PosePair& pair : pairs) pair.estimate = T_truth_estimate * pair.estimate;
  return pairs;
}

}  // namespace lidar_mapping::evaluation
