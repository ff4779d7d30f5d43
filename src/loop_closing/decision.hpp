// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/common/loop.hpp"

#include "prior.hpp"
#include "verification.hpp"

namespace lidar_mapping::loop_closing {

/// A candidate after matching.
struct Match {
  Alignment alignment;
  MatchFigures figures;
};

/// Overlap minus twice the free-space violation: what separates true places from false ones.
double margin_of(const MatchFigures& figures);

/// A verdict and why: one sentence that names figure, limit and parameter.
struct Decision {
  Verdict verdict = Verdict::kUndecided;
  std::string reason;
};

/// Holds a match against every rule, one after the other (doc/loop_closing.md); accepted only if
/// none objects.
Decision decide(const Match& match, const Prior& prior, const LoopClosingConfig& config);

/// True if the estimate knew within about a metre where an accepted match has to lie, and there it
/// lies: whatever else looks like the place can only be the same place.
bool is_unambiguous(const Match& match, const Prior& prior);

/// "overlap 0.43 below the limit 0.50 (parameter)".
std::string figure_sentence(const std::string& figure, double value, const std::string& relation,
                            double limit, const std::string& parameter);

}  // namespace lidar_mapping::loop_closing
