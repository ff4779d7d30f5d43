// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace lidar_mapping::preprocessing {

/// A message for the user: an observation or a problem.
struct Diagnostic {
  enum class Level { kInfo, kWarning };
  Level level = Level::kWarning;
  std::string text;
};

/// Messages for the user. Each subject is reported once, until it is reset.
class DiagnosticLog {
 public:
  void report(const std::string& subject, Diagnostic diagnostic) {
    if (reported_.insert(subject).second) pending_.push_back(std::move(diagnostic));
  }
  void warn(const std::string& subject, const std::string& sentence) {
    report(subject, {Diagnostic::Level::kWarning, sentence});
  }
  void inform(const std::string& subject, const std::string& sentence) {
    report(subject, {Diagnostic::Level::kInfo, sentence});
  }
  /// Allows the next message about this subject.
  void reset(const std::string& subject) { reported_.erase(subject); }
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
