#pragma once

#include "judgement.hpp"
#include "places.hpp"

namespace lidar_mapping::loop_closing {

/// A candidate for the newest key frame, what matching made of it and what became of it.
struct Trial {
  Candidate candidate;
  Match match;
  Judgement judgement;

  /// The figure that decides: overlap minus twice the free-space violation.
  double margin() const { return margin_of(match.figures); }
};

/// True if no other candidate need be matched: accepted beyond doubt.
bool settles(const Trial& trial);
/// Of several accepted trials only the best stays accepted; the others would say the same again.
void keep_best(std::vector<Trial>& trials, const Trajectory& trajectory);

Loop to_loop(const Trial& trial, const Trajectory& trajectory, const LoopClosingConfig& config);
LoopVerdict to_verdict(const Trial& trial, const Trajectory& trajectory);
/// Of a match that waited until another confirmed it.
LoopVerdict confirmed_verdict(const Loop& loop, const Loop& by);

}  // namespace lidar_mapping::loop_closing
