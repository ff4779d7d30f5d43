#pragma once

#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// Tells good matches from poor ones: by how well the points fit compared with what is usual on
/// this drive, and by how far the pose lies from the prediction.
class MatchJudge {
 public:
  explicit MatchJudge(double max_speed) : max_speed_(max_speed) {}

  /// True if more starts should be tried.
  bool in_doubt(const registration::NdtMatch& match,
                const registration::MotionBelief& prediction) const;
  /// kTracking, kDegraded or kLost.
  TrackingState judge(const registration::NdtMatch& match,
                      const registration::MotionBelief& prediction) const;
  /// Takes an accepted match into what is usual.
  void learn(const registration::NdtMatch& match);
  void reset() { usual_ = 0.0; }

 private:
  double max_speed_;
  double usual_ = 0.0;  ///< running mean of NdtMatch::quality
};

}  // namespace lidar_mapping::front_end
