// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace lidar_mapping::preprocessing {

/// A message for the user: an observation or a problem.
struct Diagnostic {
  /// Level of the log.
  enum class Level {
    kInfo,    ///< an observation
    kWarning  ///< a problem
  };
  Level level = Level::kWarning;  ///< observation or problem
  std::string text;               ///< one sentence
};

/// Messages for the user. Each subject is reported once, until it is reset.
class DiagnosticLog {
 public:
  /// Keeps the message for take(), unless the subject was reported before.
  void report(const std::string& subject, Diagnostic diagnostic) {
    if (reported_.insert(subject).second) pending_.push_back(std::move(diagnostic));
  }
  /// Reports a problem.
  void warn(const std::string& subject, const std::string& sentence) {
    report(subject, {Diagnostic::Level::kWarning, sentence});
  }
  /// Reports an observation.
  void inform(const std::string& subject, const std::string& sentence) {
    report(subject, {Diagnostic::Level::kInfo, sentence});
  }
  /// Allows the next message about this subject.
  void reset(const std::string& subject) { reported_.erase(subject); }
  /// The messages since the last call, in their order.
  std::vector<Diagnostic> take() {
    std::vector<Diagnostic> result;
    result.swap(pending_);
    return result;
  }

 private:
  std::set<std::string> reported_;
  std::vector<Diagnostic> pending_;
};

}  // namespace lidar_mapping::preprocessing
