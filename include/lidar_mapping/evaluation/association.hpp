// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lidar_mapping/common/trajectory.hpp"

namespace lidar_mapping::evaluation {

/// The same instant in two trajectories.
struct PosePair {
  Stamp stamp = 0;  ///< of the estimate
  Pose truth;       ///< in the frame of the true trajectory
  Pose estimate;    ///< in the frame of the estimated trajectory
};

/// Time between two poses up to which a pose is interpolated, s. Chosen: a vehicle changes its way
/// within a second.
constexpr double kLargestGap = 0.5;

/// Pairs every estimate with the truth at its stamp, interpolated between two poses of the truth
/// that are at most `largest_gap_s` apart; estimates in longer gaps and outside of the truth are
/// left out. If either trajectory has no stamps, line i goes with line i; throws InputError if
/// their lengths differ.
std::vector<PosePair> associate(const Trajectory& truth, const Trajectory& estimate,
                                double largest_gap_s = kLargestGap);

/// How many estimates associate() leaves out, and why.
struct LeftOut {
  std::size_t outside = 0;  ///< before the first or after the last pose of the truth
  std::size_t in_gaps = 0;  ///< between two poses of the truth that are too far apart
};
/// What associate() leaves out with gaps of kLargestGap; nothing of trajectories without stamps.
LeftOut left_out(const Trajectory& truth, const Trajectory& estimate);
/// In words, with a name for the truth: "129 lie in gaps of NAME longer than 0.5 s, 2 lie before or
/// after NAME". Empty if nothing was left out.
std::string reason_of(const LeftOut& left_out, const std::string& name);
/// What a user may do: "give a denser trajectory" if any lie in gaps, else "check the clocks of
/// both".
std::string remedy_for(const LeftOut& left_out);

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
