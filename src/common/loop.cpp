// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/loop.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

LoopVerdict verdict_on(const Loop& loop, Verdict decision, const std::string& reason) {
  LoopVerdict verdict;
  verdict.from = loop.from;
  verdict.to = loop.to;
  verdict.stamp = loop.stamp;
  verdict.source = loop.source;
  verdict.verdict = decision;
  verdict.reason = reason;
  verdict.fitness = loop.fitness;
  verdict.overlap = loop.overlap;
  return verdict;
}

std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest_verdicts(
    const std::vector<LoopVerdict>& verdicts) {
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest;
  for (const LoopVerdict& verdict : verdicts) newest[{verdict.from, verdict.to}] = verdict;
  return newest;
}

const char* to_string(LoopSource source) {
  switch (source) {
    case LoopSource::kPosition:
      return "position";
    case LoopSource::kGnss:
      return "gnss";
    case LoopSource::kAppearance:
      return "appearance";
    case LoopSource::kManual:
      return "manual";
  }
  return "";
}

LoopSource loop_source_from(const std::string& name) {
  for (const LoopSource source :
       {LoopSource::kPosition, LoopSource::kGnss, LoopSource::kAppearance, LoopSource::kManual}) {
    if (name == to_string(source)) return source;
  }
  throw InputError("loop source '" + name + "' is not position, gnss, appearance or manual");
}

const char* to_string(LoopDecision decision) {
  switch (decision) {
    case LoopDecision::kAuto:
      return "auto";
    case LoopDecision::kAccept:
      return "accept";
    case LoopDecision::kRefuse:
      return "refuse";
  }
  return "";
}

LoopDecision loop_decision_from(const std::string& name) {
  for (const LoopDecision decision :
       {LoopDecision::kAuto, LoopDecision::kAccept, LoopDecision::kRefuse}) {
    if (name == to_string(decision)) return decision;
  }
  throw InputError("loop decision '" + name + "' is not auto, accept or refuse");
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      return "accepted";
    case Verdict::kRefused:
      return "refused";
    case Verdict::kUndecided:
      return "undecided";
  }
  return "";
}

Verdict verdict_from(const std::string& name) {
  for (const Verdict verdict : {Verdict::kAccepted, Verdict::kRefused, Verdict::kUndecided}) {
    if (name == to_string(verdict)) return verdict;
  }
  throw InputError("verdict '" + name + "' is not accepted, refused or undecided");
}

}  // namespace lidar_mapping
