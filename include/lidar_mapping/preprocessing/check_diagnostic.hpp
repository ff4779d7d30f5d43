// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::preprocessing {

/// How much a finding matters to the map.
enum class Severity {
  kWarning,  ///< less is measured than could be; a map is made all the same
  kFault     ///< what is measured is wrong or unusable: no map, or a wrong one, until it is mended
};
const char* to_string(Severity severity);

/// What is wrong with an input, and what helps.
struct CheckDiagnostic {
  Severity severity = Severity::kFault;
  std::string text;
  std::string remedy;
};

/// "text: remedy".
std::string sentence(const CheckDiagnostic& diagnostic);

/// One line about an input and what is wrong with it.
struct InputReport {
  std::string input;  ///< points, imu, velocity, gnss
  std::string found;
  std::vector<CheckDiagnostic> diagnostics;
};

}  // namespace lidar_mapping::preprocessing
