// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/loop.hpp"

#include "candidates/prior.hpp"
#include "decision/verification.hpp"

namespace lidar_mapping::loop_closing {

/// The result of matching a candidate.
struct Match {
  Alignment alignment;
  MatchFigures figures;
};

/// Overlap minus twice the free-space violation: this figure separates true from false loops best.
double margin_of(const MatchFigures& figures);

/// A verdict with its reason: one sentence with figure, limit and parameter.
struct Decision {
  Verdict verdict = Verdict::kUndecided;
  std::string reason;
};

/// True if the estimate admits several locations, so that most candidates are other places. Without
/// an estimate nothing is known about that.
bool admits_other_places(const Prior& prior);

/// The check of a starting pose before the registration, which costs many times as much: by the
/// free-space violation of the two key frames there. Empty if the candidate has to be matched. It
/// is only for candidates of which most are other places: the starting pose of a right one may be
/// so far off that it fails, above all in small rooms.
std::optional<Decision> refused_at_start(double free_space_violation);

/// Applies all checks to a match, one after the other (doc/loop_closing.md). The match is accepted
/// if none of them fails.
Decision decide(const Match& match, const Prior& prior, const LoopClosingConfig& config);

/// True if the estimate was known to about a metre and an accepted match agrees with it: then all
/// other candidates can only show the same location.
bool is_unambiguous(const Match& match, const Prior& prior);

/// True if two poses are one location: less than a lane, half a storey and the turn to another
/// street apart.
bool are_one_location(const Pose& a, const Pose& b);

/// A sentence such as "overlap 0.43 below the limit 0.50 (parameter)".
std::string figure_sentence(const std::string& figure, double value, const std::string& relation,
                            double limit, const std::string& parameter);

}  // namespace lidar_mapping::loop_closing
