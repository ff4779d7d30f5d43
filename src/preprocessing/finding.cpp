// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/finding.hpp"

namespace lidar_mapping::preprocessing {

const char* to_string(Severity severity) {
  return severity == Severity::kFault ? "FAULT" : "WARNING";
}

std::string sentence(const Finding& finding) { return finding.text + ": " + finding.remedy; }

}  // namespace lidar_mapping::preprocessing
