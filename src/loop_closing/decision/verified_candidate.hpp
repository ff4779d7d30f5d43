// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "candidates/candidate_generator.hpp"
#include "decision/decision.hpp"
#include "matching/scan_alignment.hpp"

namespace lidar_mapping::loop_closing {

/// A candidate for the newest key frame with its match and the decision on it.
struct VerifiedCandidate {
  Candidate candidate;
  Match match;
  Decision decision;

  /// The deciding figure: overlap minus twice the free-space violation.
  double margin() const { return margin_of(match.figures); }
  bool is_accepted() const { return decision.verdict == Verdict::kAccepted; }
};

/// True if `a` is accepted and `b` is not, or both are alike in that and `a` has the larger margin.
bool is_better(const VerifiedCandidate& a, const VerifiedCandidate& b);

/// A candidate that is undecided, because the cloud of one of the two is not available.
VerifiedCandidate without_cloud(const Candidate& candidate);
/// A candidate that is decided on without a match, because of the free-space violation at its
/// starting pose.
VerifiedCandidate without_match(const Candidate& candidate, double free_space_violation,
                                const Decision& decision);
/// Matches a candidate from its T_from_to and decides on the match.
VerifiedCandidate verified(const Candidate& candidate, const QueryScan& query, const Submap& submap,
                           const LoopClosingConfig& config, ScanAlignment& alignment);

/// True if no other candidate has to be matched: this one is accepted and unambiguous.
bool is_conclusive(const VerifiedCandidate& verified);
/// True if a match of the candidate could only tell what the accepted one has told: from its
/// starting pose the newest key frame stands where this one has it, and where the estimate has it.
/// Never true unless constraints connect all of them, without a jump in height.
bool shows_the_same(const Candidate& candidate, const VerifiedCandidate& accepted,
                    const Trajectory& trajectory);
/// True if nothing but the match itself tells where the newest key frame is: no constraints connect
/// the two, and GNSS is no better.
bool is_unanchored(const VerifiedCandidate& verified);
/// Leaves accepted candidates undecided that are not anchored and of which another one shows nearly
/// as well that the newest key frame is elsewhere in the same segment: both places look alike.
void leave_rivals_undecided(std::vector<VerifiedCandidate>& verified, const Trajectory& trajectory);
/// Refuses all accepted candidates but the best: the others would constrain the same key frame
/// again.
void refuse_all_but_best(std::vector<VerifiedCandidate>& verified, const Trajectory& trajectory);

Loop to_loop(const VerifiedCandidate& verified, const Trajectory& trajectory,
             const LoopClosingConfig& config);
LoopVerdict to_verdict(const VerifiedCandidate& verified, const Trajectory& trajectory);
/// The verdict for a match that was accepted later, because another match agrees with it.
LoopVerdict confirmed_verdict(const Loop& loop, const Loop& by);

}  // namespace lidar_mapping::loop_closing
