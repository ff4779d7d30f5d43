// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::preprocessing {

/// Severity of a problem for the map.
enum class Severity {
  kWarning,  ///< some data are not used; a map is made nevertheless
  /// the data are wrong or unusable: there is no map, or a wrong one, until this is corrected
  kFault
};
const char* to_string(Severity severity);

/// A problem of an input, and its remedy.
struct CheckDiagnostic {
  Severity severity = Severity::kFault;
  std::string text;
  std::string remedy;
};

/// "text: remedy".
std::string sentence(const CheckDiagnostic& diagnostic);

/// The report of an input: one line about its data, and its problems.
struct InputReport {
  std::string input;  ///< points, imu, velocity, gnss
  std::string found;
  std::vector<CheckDiagnostic> diagnostics;
};

}  // namespace lidar_mapping::preprocessing
