#pragma once

#include <vector>

#include "lidar_mapping/front_end/local_map.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// Matches from several starts: coarsely and with few points from all of them, then finely from the
/// most promising ones.
class PoseSearch {
 public:
  explicit PoseSearch(const registration::NdtOptions& options) : options_(options) {}

  /// The match with the highest quality. `starts` must not be empty.
  registration::NdtMatch search(const registration::NdtPoints& points, LocalMap& map,
                                const registration::MotionBelief& prior,
                                const std::vector<registration::MotionState>& starts);
  /// Coarse iterations from `start`, with all points.
  registration::MotionState approach(const registration::NdtPoints& points, LocalMap& map,
                                     const registration::MotionBelief& prior,
                                     const registration::MotionState& start);

 private:
  registration::NdtOptions options_;
  registration::NdtMatcher matcher_;
  registration::NdtPoints few_;
};

}  // namespace lidar_mapping::front_end
