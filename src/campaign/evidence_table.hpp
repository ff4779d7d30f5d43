// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "step_checker.hpp"

namespace lidar_mapping::campaign {

/// Writes the steps of a campaign, one a line: case, stamp, state, error in metres and degrees,
/// probability, then StepEvidence by the names of its figures. fit_step_belief.py reads it.
class EvidenceTable {
 public:
  /// Throws FileError.
  explicit EvidenceTable(const std::string& path);
  /// `line` is that of the case, to_line().
  void add(const std::string& line, const std::vector<CheckedStep>& steps);
  /// Throws FileError if anything could not be written.
  void close();

 private:
  std::string path_;
  std::ofstream file_;
};

}  // namespace lidar_mapping::campaign
