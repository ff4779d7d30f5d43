// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "local_map.hpp"
#include "match_judge.hpp"

namespace lidar_mapping::front_end {

/// What is known of the motion before the match.
struct Prediction {
  registration::MotionBelief nominal;
  /// Trusts other sensors more: where the points say nothing (Zhang, Kaess, Singh 2016).
  registration::MotionBelief for_unobserved;
  /// Holds the largest accelerations for possible: once the usual one is in doubt.
  registration::MotionBelief high_noise;
};

/// Finds where a sweep was taken: finely from the prediction, coarsely first where a quick test
/// distrusts the prediction, and from many starts where the match is in doubt.
class SweepMatcher {
 public:
  struct Found {
    registration::NdtMatch match;
    std::vector<Eigen::Vector3d> degenerate_directions;  ///< follow the prediction
    bool rescued = false;
  };

  /// `neighbors`: the voxels with which the fine matches pair a point.
  explicit SweepMatcher(registration::NeighborSearch neighbors) : neighbors_(neighbors) {}

  /// `anchors` are poses around which to search if the match from the prediction is in doubt.
  Found find(const registration::NdtPoints& points, LocalMap& map, const MatchJudge& judge,
             const Prediction& prediction, const std::vector<Pose>& anchors);
  /// The best match from any of the starts.
  registration::NdtMatch search(const registration::NdtPoints& points, LocalMap& map,
                                const registration::MotionBelief& prior,
                                const std::vector<registration::MotionState>& starts);
  /// A fine match from near the solution.
  registration::NdtMatch refine(const registration::NdtPoints& points, LocalMap& map,
                                const registration::MotionBelief& prior,
                                const registration::MotionState& start);
  /// The match from where a prediction lies, without what the points say about moving along these
  /// directions (unit, the sensor's axes).
  Found match_without(const registration::NdtPoints& points, LocalMap& map,
                      const registration::MotionBelief& prediction,
                      const std::vector<Eigen::Vector3d>& directions);

 private:
  /// The match, or the one without what the points do not observe.
  Found match_observed_directions(const registration::NdtMatch& match,
                                  const registration::NdtPoints& points, LocalMap& map,
                                  const registration::MotionBelief& for_unobserved);
  registration::NdtMatch match_without_from(const registration::MotionState& start,
                                            const registration::NdtPoints& points, LocalMap& map,
                                            const registration::MotionBelief& prior,
                                            const std::vector<Eigen::Vector3d>& directions);
  /// The match, or a coarse one from there as long as the fine map is too thin to match with.
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
