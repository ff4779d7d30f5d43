// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/check_diagnostic.hpp"

namespace lidar_mapping::preprocessing {

const char* to_string(Severity severity) {
  return severity == Severity::kFault ? "FAULT" : "WARNING";
}

std::string sentence(const CheckDiagnostic& diagnostic) {
  return diagnostic.text + ": " + diagnostic.remedy;
}

}  // namespace lidar_mapping::preprocessing
