// SPDX-License-Identifier: BSD-3-Clause
#include "matching/sweep_matcher.hpp"

#include <algorithm>
#include <utility>

#include "matching/degeneracy.hpp"
#include "matching/search_starts.hpp"

namespace lidar_mapping::front_end {
namespace {

// The quick test: a fraction of the points (chosen: 300 points, a small part of a match's time) and
// a wide kernel (chosen: the start may be some decimetres off). The quality is compared with its
// running mean; fraction and weight as in match_judge.cpp (kDoubtfulQuality, kLearningRate).
constexpr std::size_t kQuickThinning = 8;
constexpr double kQuickWidening = 3.0;
constexpr double kQuickDoubtFraction = 0.75;
constexpr double kQuickLearningRate = 0.1;

// The search: all starts are scored, the better ones are refined coarsely, and the best of these
// finely. Chosen: bounds the time; half and twice of the thinnings, and half of the starts, move
// nothing (doc/results/ablation.md).
constexpr std::size_t kScoringThinning = 16;
constexpr std::size_t kCoarseThinning = 4;
constexpr std::size_t kRefinedStarts = 12;
constexpr std::size_t kFinalists = 3;
// Coarse results this close to each other lead to the same fine result (m, rad). Chosen: far within
// the convergence basin of a fine match.
constexpr double kSamePlace = 0.1;
constexpr double kSameAngle = 0.01;
/// Chosen: a result that has not converged by then was not a good result of the coarse search.
constexpr int kFinalIterations = 15;
/// The best of many starts must be better than the match from the prediction by this factor.
/// Chosen: among hundreds of starts one is a little better by chance.
constexpr double kMinQualityRatio = 1.1;
/// If a smaller fraction of the points lies in voxels with a plane, the fine map is too sparse to
/// match with: the map of a single place, seen with few rings. Chosen above a sixth, which 16 beams
/// have in simulated car parks until two metres from the start.
constexpr double kSparseMapOverlap = 0.25;
/// The coarse match is used, even if its own map is sparse, if this many times more points find a
/// plane. Chosen: the fine one of those 16 beams has a twentieth in an open field.
constexpr double kMinOverlapRatio = 2.0;
/// Weight of the prior in the coarse match. Chosen small: it may deviate from the prediction, which
/// is in doubt.
constexpr double kCoarsePriorWeight = 0.01;

NdtOptions widened(double factor) {
  NdtOptions options;
  options.kernel *= factor;
  return options;
}

NdtOptions coarse_options() {
  NdtOptions options;
  options.max_iterations = 8;
  options.translation_epsilon = 0.02;
  options.rotation_epsilon = 1e-3;
  return options;
}

/// Keeps the `count` best, in a fixed order.
void keep_best(std::vector<NdtMatch>& matches, std::size_t count) {
  std::stable_sort(matches.begin(), matches.end(),
                   [](const NdtMatch& a, const NdtMatch& b) { return a.quality > b.quality; });
  matches.resize(std::min(matches.size(), count));
}

/// Keeps the best one of matches with the same result.
void keep_distinct(std::vector<NdtMatch>& matches) {
  const auto is_beside = [](const NdtMatch& a, const NdtMatch& b) {
    const Vector6d d = difference(a.state.T_map_sensor, b.state.T_map_sensor);
    return d.head<3>().norm() < kSamePlace && d.tail<3>().norm() < kSameAngle;
  };
  keep_best(matches, matches.size());
  std::vector<NdtMatch> distinct;
  for (const NdtMatch& match : matches) {
    const bool is_new = std::none_of(distinct.begin(), distinct.end(),
                                     [&](const NdtMatch& kept) { return is_beside(kept, match); });
    if (is_new) distinct.push_back(match);
  }
  matches = std::move(distinct);
}

}  // namespace

SweepMatcher::Found SweepMatcher::find(const NdtPoints& points, LocalMap& map,
                                       const MatchJudge& judge, const Prediction& prediction,
                                       const std::vector<Pose>& anchors) {
  const MotionBelief& nominal = prediction.nominal;
  const NdtMatch fine = refine(points, map, nominal, start_for(points, map, nominal));
  const NdtMatch first = coarse_if_sparse(fine, points, map, nominal, {});
  Found found = match_observed_directions(first, points, map, prediction.for_unobserved);
  if (!judge.in_doubt(found.match, nominal)) return found;
  const MotionBelief& high_noise = prediction.high_noise;
  found = match_observed_directions(refine(points, map, high_noise, found.match.state), points, map,
                                    prediction.for_unobserved);
  const NdtMatch other = search(points, map, high_noise, starts_around(nominal.state, anchors));
  if (other.quality > kMinQualityRatio * found.match.quality) {
    found = match_observed_directions(other, points, map, prediction.for_unobserved);
  }
  found.rescued = true;
  return found;
}

SweepMatcher::Found SweepMatcher::match_observed_directions(const NdtMatch& match,
                                                            const NdtPoints& points, LocalMap& map,
                                                            const MotionBelief& for_unobserved) {
  const std::vector<Eigen::Vector3d> degenerate = degenerate_directions(match.pose_hessian);
  if (degenerate.empty()) return {match, {}};
  return match_without(points, map, for_unobserved, match.state, degenerate);
}

SweepMatcher::Found SweepMatcher::match_without(const NdtPoints& points, LocalMap& map,
                                                const MotionBelief& prior, const MotionState& start,
                                                const std::vector<Eigen::Vector3d>& directions) {
  NdtOptions options = fine_options();
  options.blind_directions = directions;
  const NdtMatch fine = matcher_.match(points, map.fine(), prior, start, options);
  return {coarse_if_sparse(fine, points, map, prior, directions), directions};
}

NdtMatch SweepMatcher::refine(const NdtPoints& points, LocalMap& map, const MotionBelief& prior,
                              const MotionState& start) {
  return matcher_.match(points, map.fine(), prior, start, fine_options());
}

NdtOptions SweepMatcher::fine_options() const {
  NdtOptions options;
  options.neighbor_search = neighbors_;
  options.parts = true;
  return options;
}

NdtMatch SweepMatcher::coarse_if_sparse(const NdtMatch& fine, const NdtPoints& points,
                                        LocalMap& map, const MotionBelief& prior,
                                        const std::vector<Eigen::Vector3d>& blind_directions) {
  if (fine.overlap > kSparseMapOverlap) return fine;
  NdtOptions options;
  options.blind_directions = blind_directions;
  options.parts = true;
  const NdtMatch coarse = matcher_.match(points, map.coarse(), prior, fine.state, options);
  return coarse.overlap > std::min(kSparseMapOverlap, kMinOverlapRatio * fine.overlap) ? coarse
                                                                                       : fine;
}

MotionState SweepMatcher::match_coarsely(const NdtPoints& points, LocalMap& map,
                                         const MotionBelief& prior, const MotionState& start) {
  const MotionBelief weak{prior.state, kCoarsePriorWeight * prior.information};
  return matcher_.match(points, map.coarse(), weak, start, coarse_options()).state;
}

MotionState SweepMatcher::start_for(const NdtPoints& points, LocalMap& map,
                                    const MotionBelief& prediction) {
  thinned_points_.assign_thinned(points, kQuickThinning);
  const double quick_quality =
      matcher_.evaluate(thinned_points_, map.fine(), prediction.state, widened(kQuickWidening))
          .quality;
  const bool is_doubtful = quick_quality < kQuickDoubtFraction * mean_quick_quality_;
  mean_quick_quality_ += kQuickLearningRate * (quick_quality - mean_quick_quality_);
  return is_doubtful ? match_coarsely(points, map, prediction, prediction.state) : prediction.state;
}

NdtMatch SweepMatcher::search(const NdtPoints& points, LocalMap& map, const MotionBelief& prior,
                              const std::vector<MotionState>& starts) {
  std::vector<NdtMatch> found;
  thinned_points_.assign_thinned(points, kScoringThinning);
  for (const MotionState& start : starts) {
    found.push_back(
        matcher_.evaluate(thinned_points_, map.coarse(), start, widened(kQuickWidening)));
  }
  keep_best(found, kRefinedStarts);
  thinned_points_.assign_thinned(points, kCoarseThinning);
  for (NdtMatch& match : found) {
    const MotionState state = match_coarsely(thinned_points_, map, prior, match.state);
    match = matcher_.evaluate(thinned_points_, map.fine(), state, widened(kQuickWidening));
  }
  keep_distinct(found);
  keep_best(found, kFinalists);
  NdtOptions options = fine_options();
  options.max_iterations = kFinalIterations;
  for (NdtMatch& match : found) {
    match = matcher_.match(points, map.fine(), prior, match.state, options);
  }
  keep_best(found, 1);
  return coarse_if_sparse(found.front(), points, map, prior, {});
}

}  // namespace lidar_mapping::front_end
