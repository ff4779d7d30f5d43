// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/evaluation/association.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

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

/// The line that lies nearest to the true positions.
struct Line {
  Eigen::Vector3d centre;
  Eigen::Vector3d direction;
  double spread_across;  ///< root mean square of the positions along the wider axis across, m
};

Line line_of_truth(const std::vector<PosePair>& pairs) {
  const auto count = static_cast<double>(pairs.size());
  Line line;
  line.centre.setZero();
  for (const PosePair& pair : pairs) line.centre += pair.truth.translation / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d d = pair.truth.translation - line.centre;
    covariance += d * d.transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  line.direction = solver.eigenvectors().col(2);
  line.spread_across = std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
  return line;
}

/// Root mean square of the distances across the line between positions of a pair, m.
double residual_across(const std::vector<PosePair>& pairs, const Pose& T_truth_estimate,
                       const Line& line) {
  double squares = 0.0;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d d = pair.truth.translation - T_truth_estimate * pair.estimate.translation;
    squares += d.cross(line.direction).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

/// The angle (rad) about the line by which the estimate has to be turned so that its orientations
/// come nearest to the true ones: it maximizes the sum of the traces of the remaining rotations.
double turn_about(const Line& line, const std::vector<PosePair>& pairs,
                  const Pose& T_truth_estimate) {
  double real = 0.0;
  double about_line = 0.0;
  double mixed = 0.0;
  for (const PosePair& pair : pairs) {
    const Eigen::Quaterniond turn =
        pair.truth.rotation * (T_truth_estimate.rotation * pair.estimate.rotation).conjugate();
    const double s = turn.vec().dot(line.direction);
    real += turn.w() * turn.w();
    about_line += s * s;
    mixed += turn.w() * s;
  }
  return std::atan2(2.0 * mixed, real - about_line);
}

/// Positions on a line leave the rotation about it free: orientations determine it then.
Pose with_known_roll(const std::vector<PosePair>& pairs, const Pose& T_truth_estimate) {
  // Of the residuals. Chosen: with fewer, the rotation is off by about 20 degrees or more.
  constexpr double kLeastSpread = 3.0;
  const Line line = line_of_truth(pairs);
  if (line.spread_across > kLeastSpread * residual_across(pairs, T_truth_estimate, line)) {
    return T_truth_estimate;
  }
  const double angle = turn_about(line, pairs, T_truth_estimate);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, line.direction));
  return Pose{turn, line.centre - turn * line.centre} * T_truth_estimate;
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

LeftOut left_out(const Trajectory& truth, const Trajectory& estimate) {
  LeftOut counts;
  if (!truth.has_stamps || !estimate.has_stamps) return counts;
  for (const StampedPose& entry : estimate.poses) {
    if (pose_at(entry.stamp, truth, kLargestGap)) continue;
    const bool is_within = !truth.poses.empty() && entry.stamp > truth.poses.front().stamp &&
                           entry.stamp < truth.poses.back().stamp;
    ++(is_within ? counts.in_gaps : counts.outside);
  }
  return counts;
}

std::string reason_of(const LeftOut& left_out, const std::string& name) {
  std::vector<std::string> reasons;
  if (left_out.in_gaps > 0) {
    reasons.push_back(formatted("%zu lie in gaps of %s longer than %g s", left_out.in_gaps,
                                name.c_str(), kLargestGap));
  }
  if (left_out.outside > 0) {
    reasons.push_back(formatted("%zu lie before or after %s", left_out.outside, name.c_str()));
  }
  return joined(reasons);
}

std::string remedy_for(const LeftOut& left_out) {
  return left_out.in_gaps > 0 ? "give a denser trajectory" : "check the clocks of both";
}

Pose rigid_alignment(const std::vector<PosePair>& pairs) {
  return with_known_roll(pairs, Pose::from_matrix(umeyama(pairs, false)));
}

SimilarityAlignment similarity_alignment(const std::vector<PosePair>& pairs) {
  Eigen::Matrix4d matrix = umeyama(pairs, true);
  if (!moves(pairs, &PosePair::truth) || !moves(pairs, &PosePair::estimate)) {
    throw InputError("a scale needs a truth and an estimate that move");
  }
  const double scale = matrix.topLeftCorner<3, 3>().col(0).norm();
  matrix.topLeftCorner<3, 3>() /= scale;
  return {with_known_roll(scaled(pairs, scale), Pose::from_matrix(matrix)), scale};
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
