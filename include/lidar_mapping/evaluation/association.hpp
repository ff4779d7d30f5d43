// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/trajectory.hpp"

namespace lidar_mapping::evaluation {

/// The same instant in two trajectories.
struct PosePair {
  Stamp stamp = 0;  ///< of the estimate
  Pose truth;       ///< in the frame of the true trajectory
  Pose estimate;    ///< in the frame of the estimated trajectory
};

/// Pairs every estimate with the truth at its stamp, interpolated between two poses of the truth
/// that are at most `largest_gap_s` apart; estimates outside of the truth are left out. If either
/// trajectory has no stamps, line i goes with line i; throws InputError if their lengths differ.
std::vector<PosePair> associate(const Trajectory& truth, const Trajectory& estimate,
                                double largest_gap_s = 0.5);

/// The rigid motion T_truth_estimate that brings the estimated positions nearest to the true ones
/// in the least-squares sense (Umeyama 1991, without scale). Positions on a line, as of a straight
/// tunnel, leave the rotation about it free; there it brings the orientations nearest to each
/// other. Throws InputError for less than three pairs.
Pose rigid_alignment(const std::vector<PosePair>& pairs);

/// A rigid motion with a scale of the estimated positions, which is to be applied first.
struct SimilarityAlignment {
  Pose T_truth_estimate;  ///< of the scaled estimate
  double scale = 1.0;     ///< factor of the estimated positions
};
/// As rigid_alignment(), with a scale (Umeyama 1991). Throws InputError for less than three pairs,
/// and if all positions of one trajectory are the same.
SimilarityAlignment similarity_alignment(const std::vector<PosePair>& pairs);

/// The pairs with the estimated positions multiplied by `scale`.
std::vector<PosePair> scaled(std::vector<PosePair> pairs, double scale);

/// The pairs with their estimates moved by T_truth_estimate.
std::vector<PosePair> aligned(std::vector<PosePair> pairs, const Pose& T_truth_estimate);

}  // namespace lidar_mapping::evaluation
