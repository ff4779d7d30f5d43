// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// How a loop candidate was found.
enum class LoopSource {
  kPosition,    ///< their estimated poses lie near each other
  kGnss,        ///< GNSS places them near each other
  kAppearance,  ///< their clouds look alike
  kManual       ///< named by the user
};

/// Decision of the user about a loop; it overrides that of the graph.
enum class LoopDecision {
  kAuto,    ///< none: the graph decides
  kAccept,  ///< the loop is right
  kRefuse   ///< the loop is wrong and left out
};

/// Two key frames that observe the same place, and their relative pose.
struct Loop {
  KeyFrameIndex from = 0;  ///< the older one
  KeyFrameIndex to = 0;    ///< the newer one
  Stamp stamp = 0;         ///< of `to`
  Pose T_from_to;          ///< as matched: pose of base_link at `to` in base_link at `from`
  Covariance6 covariance = Covariance6::Identity();  ///< of T_from_to, axes of base_link at `to`
  double fitness = 0.0;  ///< mean squared distance of paired points, m^2
  double overlap = 0.0;  ///< fraction of the scan with a partner in the submap, 0 to 1
  LoopSource source = LoopSource::kPosition;    ///< how it was found
  LoopDecision decision = LoopDecision::kAuto;  ///< of the user
};

/// Decision about a loop candidate.
enum class Verdict {
  kAccepted,  ///< the two key frames observe the same place, as matched
  kRefused,   ///< they do not, or the match may be wrong
  kUndecided  ///< the evidence is not sufficient, or not yet
};

/// Decision about a loop candidate with its reason and figures.
struct LoopVerdict {
  KeyFrameIndex from = 0;                     ///< the older key frame
  KeyFrameIndex to = 0;                       ///< the newer key frame
  Stamp stamp = 0;                            ///< of `to`
  LoopSource source = LoopSource::kPosition;  ///< how it was found
  Verdict verdict = Verdict::kUndecided;      ///< the decision
  std::string reason;                         ///< one sentence: figure, limit, parameter
  double distance = 0.0;                      ///< between the poses before matching, m
  double fitness = 0.0;                       ///< mean squared distance of paired points, m^2
  /// Fraction of the points above ground with a partner, 0 to 1.
  double overlap = 0.0;
  /// Fraction of the points above ground in space that the other side observed as free, 0 to 1.
  double free_space_violation = 0.0;
  /// How well the walls constrain the horizontal position: 0.5 at best, 0 in a smooth tunnel.
  double horizontal_eigenvalue = 0.0;
  double innovation = 0.0;  ///< squared, normalised by the prior's covariance, 6 degrees of freedom
};

/// A verdict on a loop, with what the loop knows of its match.
LoopVerdict verdict_on(const Loop& loop, Verdict decision, const std::string& reason);
/// The reason of a match between segments that nothing connects yet: it waits until matches that
/// agree with it span `path_length` m (unanchored_path_length).
std::string waiting_reason(double path_length);
/// Whether a verdict is on a match that waits for others (waiting_reason()). Other undecided ones
/// lack evidence and wait for nothing.
bool is_waiting(const LoopVerdict& verdict);
/// The newest verdict on each pair of key frames (from, to).
std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest_verdicts(
    const std::vector<LoopVerdict>& verdicts);

/// "position", "gnss", "appearance", "manual".
const char* to_string(LoopSource source);
/// The source of that name. Throws InputError for another word.
LoopSource loop_source_from(const std::string& name);
/// "auto", "accept", "refuse".
const char* to_string(LoopDecision decision);
/// The decision of that name. Throws InputError for another word.
LoopDecision loop_decision_from(const std::string& name);
/// "accepted", "refused", "undecided".
const char* to_string(Verdict verdict);
/// The verdict of that name. Throws InputError for another word.
Verdict verdict_from(const std::string& name);

}  // namespace lidar_mapping
