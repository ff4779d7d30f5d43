// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "judgement/match_judge.hpp"
#include "local_map/local_map.hpp"
#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// The predicted motion before the match.
struct Prediction {
  MotionBelief nominal;
  /// Gives more weight to other sensors; used where the points do not observe the motion (Zhang,
  /// Kaess, Singh 2016).
  MotionBelief for_unobserved;
  /// Allows the largest accelerations; used once the nominal prediction is in doubt.
  MotionBelief high_noise;
};

/// Finds the pose of a sweep. It matches finely from the prediction; if a quick test shows that the
/// prediction is poor, it matches coarsely first; if the match is in doubt, it searches from many
/// starting poses.
class SweepMatcher {
 public:
  struct Found {
    NdtMatch match;
    /// along these the pose follows the prediction
    std::vector<Eigen::Vector3d> degenerate_directions;
    bool rescued = false;
  };

  /// `neighbors`: the voxels among which the fine matches pair a point.
  explicit SweepMatcher(NeighborSearch neighbors) : neighbors_(neighbors) {}

  /// `anchors` are additional poses around which to search if the match from the prediction is in
  /// doubt.
  Found find(const NdtPoints& points, LocalMap& map, const MatchJudge& judge,
             const Prediction& prediction, const std::vector<Pose>& anchors);
  /// The best match from any of the starts.
  NdtMatch search(const NdtPoints& points, LocalMap& map, const MotionBelief& prior,
                  const std::vector<MotionState>& starts);
  /// A fine match that starts near the solution.
  NdtMatch refine(const NdtPoints& points, LocalMap& map, const MotionBelief& prior,
                  const MotionState& start);
  /// The same without the information of the points about translation along these directions (unit
  /// vectors, in the sensor's axes).
  Found match_without(const NdtPoints& points, LocalMap& map, const MotionBelief& prior,
                      const MotionState& start, const std::vector<Eigen::Vector3d>& directions);

 private:
  /// The match or, if the points do not observe some directions, a match without their information
  /// about these directions.
  Found match_observed_directions(const NdtMatch& match, const NdtPoints& points, LocalMap& map,
                                  const MotionBelief& for_unobserved);
  /// Options of a match with the fine map.
  NdtOptions fine_options() const;
  /// The match or, as long as the fine map is too sparse to match with, a coarse match that starts
  /// there.
  NdtMatch coarse_if_sparse(const NdtMatch& fine, const NdtPoints& points, LocalMap& map,
                            const MotionBelief& prior,
                            const std::vector<Eigen::Vector3d>& blind_directions);
  MotionState start_for(const NdtPoints& points, LocalMap& map, const MotionBelief& prediction);
  MotionState match_coarsely(const NdtPoints& points, LocalMap& map, const MotionBelief& prior,
                             const MotionState& start);

  NeighborSearch neighbors_;
  NdtMatcher matcher_;
  NdtPoints thinned_points_;
  double mean_quick_quality_ = 0.0;  ///< running mean of the quick test's quality
};

}  // namespace lidar_mapping::front_end
