// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "judgement/match_judge.hpp"
#include "judgement/step_belief.hpp"
#include "judgement/step_origin.hpp"
#include "tracking/tracker_state.hpp"

namespace lidar_mapping::front_end {

/// The match of a scan, and what is known about how it was found.
struct StepMatch {
  SweepMatcher::Found found;
  MotionBelief prior;  ///< the belief before the match
  /// The position comes from vertical structures, and the points were matched without their
  /// information about it (FalseStandstillRecovery).
  bool is_recovered = false;
};

/// Judges the match of a scan as the end of a step from the last claimed pose: by the quality of
/// the match, by whether a vehicle can move like this, and by the evidence for and against it.
class StepJudge {
 public:
  explicit StepJudge(double max_speed) : match_judge_(max_speed) {}

  /// To be called with a new map.
  void reset();
  /// To be called before matches of another kind, for which other values of the quality are usual.
  void reset_usual_quality() { match_judge_.reset(); }
  /// To be called for each scan, with the time since the previous one.
  void advance(double seconds);
  /// Writes the match and all that follows from it into the status. `state` is the state before the
  /// match is adopted, `since_matched` the time since the last match (s).
  StepBelief judge(const StepMatch& match, const TrackerState& state, const SweepSampler& sweep,
                   double since_matched, FrontEndStatus& status);
  /// Learns the usual quality from an accepted match.
  void learn(const NdtMatch& match) { match_judge_.learn(match); }
  /// To be called with the result of each scan.
  void finish(const TrackedScan& tracked) { origin_.update(tracked); }

  const MatchJudge& match_judge() const { return match_judge_; }

 private:
  StepEvidence collect_evidence(const StepMatch& match, const TrackerState& state,
                                const SweepSampler& sweep, double since_matched) const;
  bool is_possible(const NdtMatch& match, const TrackerState& state, double since_matched) const;

  MatchJudge match_judge_;
  DoubtState doubt_;
  StepOrigin origin_;
  double since_scan_ = 0.0;  ///< s from the previous scan to the present one
};

}  // namespace lidar_mapping::front_end
