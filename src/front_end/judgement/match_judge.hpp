// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/front_end_status.hpp"

#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// Separates good matches from poor ones: by how well the points fit, compared with the usual value
/// of this drive, and by the distance of the pose from the prediction.
class MatchJudge {
 public:
  explicit MatchJudge(double max_speed) : max_speed_(max_speed) {}

  /// True if more starting poses should be tried.
  bool in_doubt(const NdtMatch& match, const MotionBelief& prediction) const;
  /// kTracking, kDegraded or kLost.
  TrackingState judge(const NdtMatch& match, const MotionBelief& prediction) const;
  /// False for a step that no vehicle can make: faster than the maximum speed, or than two turns
  /// per second.
  bool is_possible_motion(const Pose& T_from_to, double seconds) const;
  /// Updates the usual values with an accepted match.
  void learn(const NdtMatch& match);
  void reset() { mean_quality_ = mean_pair_quality_ = 0.0; }

 private:
  bool has_usual_pair_quality(const NdtMatch& match) const;
  /// True if the quality is less than `fraction` of the usual quality, and this is not only because
  /// the map ends here.
  bool is_below(double fraction, const NdtMatch& match) const;

  double max_speed_;
  double mean_quality_ = 0.0;       ///< running mean of NdtMatch::quality
  double mean_pair_quality_ = 0.0;  ///< running mean of NdtMatch::quality per pair
};

}  // namespace lidar_mapping::front_end
