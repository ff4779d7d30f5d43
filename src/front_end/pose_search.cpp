#include "lidar_mapping/front_end/pose_search.hpp"

#include <algorithm>

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kThinning = 4;
constexpr std::size_t kFinalists = 3;
constexpr int kCoarseIterations = 8;
/// The coarse match may leave the prediction this much more easily.
constexpr double kPriorWeight = 0.01;

registration::NdtOptions coarse_options(registration::NdtOptions options) {
  options.max_iterations = kCoarseIterations;
  options.translation_epsilon = 0.02;
  options.rotation_epsilon = 1e-3;
  return options;
}

registration::MotionBelief weakened(registration::MotionBelief belief) {
  belief.information *= kPriorWeight;
  return belief;
}

}  // namespace

registration::MotionState PoseSearch::approach(const registration::NdtPoints& points, LocalMap& map,
                                               const registration::MotionBelief& prior,
                                               const registration::MotionState& start) {
  return matcher_.match(points, map.coarse(), weakened(prior), start, coarse_options(options_))
      .state;
}

registration::NdtMatch PoseSearch::search(const registration::NdtPoints& points, LocalMap& map,
                                          const registration::MotionBelief& prior,
                                          const std::vector<registration::MotionState>& starts) {
  few_.assign_thinned(points, kThinning);
  std::vector<registration::NdtMatch> found;
  for (const registration::MotionState& start : starts) {
    const registration::MotionState near = approach(few_, map, prior, start);
    registration::NdtOptions wide = options_;
    wide.kernel *= 3.0;
    found.push_back(matcher_.evaluate(few_, map.fine(), near, wide));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.quality > b.quality; });
  found.resize(std::min(found.size(), kFinalists));
  registration::NdtMatch best;
  for (const registration::NdtMatch& start : found) {
    const registration::NdtMatch match =
        matcher_.match(points, map.fine(), prior, start.state, options_);
    if (match.quality > best.quality) best = match;
  }
  return best;
}

}  // namespace lidar_mapping::front_end
