// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "judgement/match_judge.hpp"
#include "local_map/local_map.hpp"

namespace lidar_mapping::front_end {

/// The predicted motion before the match.
struct Prediction {
  registration::MotionBelief nominal;
  /// Gives more weight to other sensors; used where the points do not observe the motion (Zhang,
  /// Kaess, Singh 2016).
  registration::MotionBelief for_unobserved;
  /// Allows the largest accelerations; used once the nominal prediction is in doubt.
  registration::MotionBelief high_noise;
};

/// Finds the pose of a sweep. It matches finely from the prediction; if a quick test shows that the
/// prediction is poor, it matches coarsely first; if the match is in doubt, it searches from many
/// starting poses.
class SweepMatcher {
 public:
  struct Found {
    registration::NdtMatch match;
    /// along these the pose follows the prediction
    std::vector<Eigen::Vector3d> degenerate_directions;
    bool rescued = false;
  };

  /// `neighbors`: the voxels among which the fine matches pair a point.
  explicit SweepMatcher(registration::NeighborSearch neighbors) : neighbors_(neighbors) {}

  /// `anchors` are additional poses around which to search if the match from the prediction is in
  /// doubt.
  Found find(const registration::NdtPoints& points, LocalMap& map, const MatchJudge& judge,
             const Prediction& prediction, const std::vector<Pose>& anchors);
  /// The best match from any of the starts.
  registration::NdtMatch search(const registration::NdtPoints& points, LocalMap& map,
                                const registration::MotionBelief& prior,
                                const std::vector<registration::MotionState>& starts);
  /// A fine match that starts near the solution.
  registration::NdtMatch refine(const registration::NdtPoints& points, LocalMap& map,
                                const registration::MotionBelief& prior,
                                const registration::MotionState& start);
  /// The same without the information of the points about translation along these directions (unit
  /// vectors, in the sensor's axes).
  Found match_without(const registration::NdtPoints& points, LocalMap& map,
                      const registration::MotionBelief& prior,
                      const registration::MotionState& start,
                      const std::vector<Eigen::Vector3d>& directions);

 private:
  /// The match or, if the points do not observe some directions, a match without their information
  /// about these directions.
  Found match_observed_directions(const registration::NdtMatch& match,
                                  const registration::NdtPoints& points, LocalMap& map,
                                  const registration::MotionBelief& for_unobserved);
  /// Options of a match with the fine map.
  registration::NdtOptions fine_options() const;
  /// The match or, as long as the fine map is too sparse to match with, a coarse match that starts
  /// there.
  registration::NdtMatch coarse_if_sparse(const registration::NdtMatch& fine,
                                          const registration::NdtPoints& points, LocalMap& map,
                                          const registration::MotionBelief& prior,
                                          const std::vector<Eigen::Vector3d>& blind_directions);
  registration::MotionState start_for(const registration::NdtPoints& points, LocalMap& map,
                                      const registration::MotionBelief& prediction);
  registration::MotionState match_coarsely(const registration::NdtPoints& points, LocalMap& map,
                                           const registration::MotionBelief& prior,
                                           const registration::MotionState& start);

  registration::NeighborSearch neighbors_;
  registration::NdtMatcher matcher_;
  registration::NdtPoints thinned_points_;
  double mean_quick_quality_ = 0.0;  ///< running mean of the quick test's quality
};

}  // namespace lidar_mapping::front_end
