// SPDX-License-Identifier: BSD-3-Clause
#include "decision/verified_candidate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sight.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Matches of a scan with two places that look alike are equally good up to this difference of the
// margin. Measured: in simulated twin streets it is at most 0.06; a changed place loses more.
constexpr double kRivalMargin = 0.15;
// m. Poses of one key frame that are farther apart are two places. Chosen: above the errors of a
// drive that is not optimised yet, below the distance of two streets.
constexpr double kOtherPlace = 10.0;

/// The pose of the newest key frame by a match, in the newest estimate of the other one's segment.
Pose pose_by(const VerifiedCandidate& verified, const Trajectory& trajectory) {
  return trajectory[verified.candidate.node].T_map_base * verified.match.alignment.T_target_source;
}

Eigen::Vector3d position_by(const VerifiedCandidate& verified, const Trajectory& trajectory) {
  return pose_by(verified, trajectory).translation;
}

bool are_rivals(const VerifiedCandidate& a, const VerifiedCandidate& b,
                const Trajectory& trajectory) {
  if (!a.is_accepted() || !b.is_accepted() || !is_unanchored(a) || !is_unanchored(b)) return false;
  if (trajectory[a.candidate.node].segment != trajectory[b.candidate.node].segment) return false;
  return std::abs(a.margin() - b.margin()) <= kRivalMargin &&
         (position_by(a, trajectory) - position_by(b, trajectory)).norm() > kOtherPlace;
}

/// The match as a loop, with the covariance still to come.
Loop as_loop(const VerifiedCandidate& verified, const Trajectory& trajectory) {
  const TrajectoryNode& newest = trajectory[trajectory.size() - 1];
  Loop loop;
  loop.from = trajectory[verified.candidate.node].index;
  loop.to = newest.index;
  loop.stamp = newest.stamp;
  loop.T_from_to = verified.match.alignment.T_target_source;
  loop.fitness = verified.match.figures.fitness;
  loop.overlap = verified.match.figures.overlap;
  loop.source = verified.candidate.source;
  return loop;
}

/// The Hessian includes only noise. The lower bound is the accuracy of the submap itself, which is
/// worse for who sees it from elsewhere.
Covariance6 with_lower_bound(const Match& match, const LoopClosingConfig& config) {
  const double growth =
      growth_of_error(match.alignment.T_target_source.translation.norm(), match.figures.sight);
  return match.alignment.covariance +
         diagonal_covariance(growth * config.min_stddev_x, growth * config.min_stddev_q);
}

}  // namespace

bool is_better(const VerifiedCandidate& a, const VerifiedCandidate& b) {
  return a.is_accepted() != b.is_accepted() ? a.is_accepted() : a.margin() > b.margin();
}

VerifiedCandidate without_cloud(const Candidate& candidate) {
  VerifiedCandidate result{
      candidate,
      {},
      {Verdict::kUndecided, "the cloud of one of the two key frames is not available"}};
  result.match.alignment.T_target_source = candidate.T_from_to;
  return result;
}

VerifiedCandidate without_match(const Candidate& candidate, double free_space_violation,
                                const Decision& decision) {
  VerifiedCandidate result{candidate, {}, decision};
  result.match.alignment.T_target_source = candidate.T_from_to;
  result.match.figures.free_space_violation = free_space_violation;
  return result;
}

VerifiedCandidate verified(const Candidate& candidate, const QueryScan& query, const Submap& submap,
                           const LoopClosingConfig& config, ScanAlignment& alignment) {
  VerifiedCandidate result{candidate, {}, {}};
  Match& match = result.match;
  match.alignment = alignment.align(query.points, submap.surface, candidate.T_from_to);
  match.figures =
      measure_match(query, submap, match.alignment.T_target_source, config.fitness_score_max_range);
  if (candidate.prior.height_jumps > 0.0) match.figures.roofed = roofed_fraction(submap);
  result.decision = decide(match, candidate.prior, config);
  return result;
}

bool is_conclusive(const VerifiedCandidate& verified) {
  return verified.is_accepted() && is_unambiguous(verified.match, verified.candidate.prior);
}

bool shows_the_same(const Candidate& candidate, const VerifiedCandidate& accepted,
                    const Trajectory& trajectory) {
  const auto is_of_the_map = [](const Candidate& c) {
    return c.prior.anchored && !(c.prior.height_jumps > 0.0);
  };
  if (!is_of_the_map(candidate) || !is_of_the_map(accepted.candidate)) return false;
  const Pose matched = pose_by(accepted, trajectory);
  return are_one_location(matched, trajectory[trajectory.size() - 1].T_map_base) &&
         are_one_location(matched, trajectory[candidate.node].T_map_base * candidate.T_from_to);
}

bool is_unanchored(const VerifiedCandidate& verified) {
  const Prior& prior = verified.candidate.prior;
  return !prior.anchored && !gnss_is_more_certain(prior);
}

void leave_rivals_undecided(std::vector<VerifiedCandidate>& verified,
                            const Trajectory& trajectory) {
  std::vector<std::optional<KeyFrameIndex>> rivals;
  for (const VerifiedCandidate& entry : verified) {
    const auto rival = std::find_if(
        verified.begin(), verified.end(),
        [&](const VerifiedCandidate& other) { return are_rivals(entry, other, trajectory); });
    rivals.emplace_back();
    if (rival != verified.end()) rivals.back() = trajectory[rival->candidate.node].index;
  }
  for (std::size_t i = 0; i < verified.size(); ++i) {
    if (!rivals[i]) continue;
    verified[i].decision = {Verdict::kUndecided,
                            "the two segments are not connected yet, and key frame " +
                                std::to_string(*rivals[i]) +
                                ", at another place, matches equally well"};
  }
}

void refuse_all_but_best(std::vector<VerifiedCandidate>& verified, const Trajectory& trajectory) {
  // The best one comes first in this order.
  const auto best = std::min_element(verified.begin(), verified.end(), is_better);
  for (VerifiedCandidate& entry : verified) {
    if (!entry.is_accepted() || &entry == &*best) continue;
    const KeyFrameIndex better = trajectory[best->candidate.node].index;
    entry.decision = {
        Verdict::kRefused,
        figure_sentence("overlap minus twice the free-space violation", entry.margin(), "below",
                        best->margin(), "of the match with key frame " + std::to_string(better))};
  }
}

Loop to_loop(const VerifiedCandidate& verified, const Trajectory& trajectory,
             const LoopClosingConfig& config) {
  Loop loop = as_loop(verified, trajectory);
  loop.covariance = with_lower_bound(verified.match, config);
  return loop;
}

LoopVerdict to_verdict(const VerifiedCandidate& verified, const Trajectory& trajectory) {
  LoopVerdict verdict = verdict_on(as_loop(verified, trajectory), verified.decision.verdict,
                                   verified.decision.reason);
  verdict.distance = verified.candidate.prior.T_from_to.translation.norm();
  verdict.free_space_violation = verified.match.figures.free_space_violation;
  verdict.horizontal_eigenvalue = verified.match.figures.horizontal_eigenvalue;
  verdict.innovation =
      innovation_of(verified.candidate.prior, verified.match.alignment.T_target_source).whole;
  return verdict;
}

LoopVerdict confirmed_verdict(const Loop& loop, const Loop& by) {
  return verdict_on(loop, Verdict::kAccepted,
                    "the match of key frames " + std::to_string(by.from) + " and " +
                        std::to_string(by.to) + " confirms it (unanchored_path_length)");
}

}  // namespace lidar_mapping::loop_closing
