// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "candidate_generator.hpp"
#include "decision.hpp"

namespace lidar_mapping::loop_closing {

/// A candidate for the newest key frame, what matching made of it and what became of it.
struct VerifiedCandidate {
  Candidate candidate;
  Match match;
  Decision decision;

  /// The figure that decides: overlap minus twice the free-space violation.
  double margin() const { return margin_of(match.figures); }
};

/// True if no other candidate need be matched: accepted beyond doubt.
bool is_conclusive(const VerifiedCandidate& verified);
/// Of several accepted verified only the best stays accepted; the others would say the same again.
void keep_best(std::vector<VerifiedCandidate>& verified, const Trajectory& trajectory);

Loop to_loop(const VerifiedCandidate& verified, const Trajectory& trajectory,
             const LoopClosingConfig& config);
LoopVerdict to_verdict(const VerifiedCandidate& verified, const Trajectory& trajectory);
/// Of a match that waited until another confirmed it.
LoopVerdict confirmed_verdict(const Loop& loop, const Loop& by);

}  // namespace lidar_mapping::loop_closing
