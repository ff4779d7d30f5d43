// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// Where the suspicion came from that two key frames see the same place.
enum class LoopSource { kPosition, kGnss, kAppearance, kManual };

/// What a person said of a loop. It stands above what the graph thinks of it.
enum class LoopDecision { kAuto, kAccept, kRefuse };

/// Two key frames that see the same place, and how they lie to each other.
struct Loop {
  KeyFrameIndex from = 0;  ///< the older one
  KeyFrameIndex to = 0;
  Stamp stamp = 0;  ///< of `to`
  Pose T_from_to;
  Covariance6 covariance = Covariance6::Identity();
  double fitness = 0.0;  ///< mean squared distance of paired points, m^2
  double overlap = 0.0;  ///< share of the scan that the submap explains
  LoopSource source = LoopSource::kPosition;
  LoopDecision decision = LoopDecision::kAuto;
};

enum class Verdict { kAccepted, kRefused, kUndecided };

/// What became of a loop candidate, and why.
struct LoopVerdict {
  KeyFrameIndex from = 0;
  KeyFrameIndex to = 0;
  Stamp stamp = 0;
  LoopSource source = LoopSource::kPosition;
  Verdict verdict = Verdict::kUndecided;
  std::string reason;                  ///< one sentence: figure, limit, parameter
  double distance = 0.0;               ///< between the poses before matching, m
  double fitness = 0.0;                ///< m^2
  double overlap = 0.0;                ///< above ground, 0 to 1
  double free_space_violation = 0.0;   ///< 0 to 1
  double horizontal_eigenvalue = 0.0;  ///< 0 to 0.5
  double innovation = 0.0;  ///< squared, normalised by the prior's covariance, 6 degrees of freedom
};

/// "position", "gnss", "appearance", "manual"; and back (throws InputError for another word).
const char* to_string(LoopSource source);
LoopSource loop_source_from(const std::string& name);
/// "auto", "accept", "refuse"; and back.
const char* to_string(LoopDecision decision);
LoopDecision loop_decision_from(const std::string& name);
/// "accepted", "refused", "undecided"; and back.
const char* to_string(Verdict verdict);
Verdict verdict_from(const std::string& name);

}  // namespace lidar_mapping
