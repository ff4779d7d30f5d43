// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/loop.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping {
namespace {

// Names in the order of the values.
constexpr std::array<const char*, 4> kSources = {"position", "gnss", "appearance", "manual"};
constexpr std::array<const char*, 3> kDecisions = {"auto", "accept", "refuse"};
constexpr std::array<const char*, 3> kVerdicts = {"accepted", "refused", "undecided"};

// By which is_waiting() knows them; sessions hold it since their first version.
constexpr const char* kWaiting =
    "the two segments are not connected yet, and the matches that agree with each other cover less "
    "than";

template <typename Value, typename Names>
const char* name_of(Value value, const Names& names) {
  return names[static_cast<std::size_t>(value)];
}

/// `kind`: what a name of another value is called in the error.
template <typename Value, typename Names>
Value value_of(const std::string& name, const Names& names, const std::string& kind) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Value>(found - names.begin());
  const std::vector<std::string> all_but_one(names.begin(), names.end() - 1);
  throw InputError(kind + " '" + name + "' is not " + joined(all_but_one) + " or " + names.back());
}

}  // namespace

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

std::string waiting_reason(double path_length) {
  return formatted("%s %g m of path (unanchored_path_length)", kWaiting, path_length);
}

bool is_waiting(const LoopVerdict& verdict) {
  return verdict.verdict == Verdict::kUndecided && verdict.reason.rfind(kWaiting, 0) == 0;
}

std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest_verdicts(
    const std::vector<LoopVerdict>& verdicts) {
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest;
  for (const LoopVerdict& verdict : verdicts) newest[{verdict.from, verdict.to}] = verdict;
  return newest;
}

const char* to_string(LoopSource source) { return name_of(source, kSources); }
LoopSource loop_source_from(const std::string& name) {
  return value_of<LoopSource>(name, kSources, "loop source");
}

const char* to_string(LoopDecision decision) { return name_of(decision, kDecisions); }
LoopDecision loop_decision_from(const std::string& name) {
  return value_of<LoopDecision>(name, kDecisions, "loop decision");
}

const char* to_string(Verdict verdict) { return name_of(verdict, kVerdicts); }
Verdict verdict_from(const std::string& name) {
  return value_of<Verdict>(name, kVerdicts, "verdict");
}

}  // namespace lidar_mapping
