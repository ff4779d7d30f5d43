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
/// "WARNING", "FAULT".
inline const char* to_string(Severity severity) {
  return severity == Severity::kFault ? "FAULT" : "WARNING";
}

/// A problem of an input, and its remedy.
struct CheckDiagnostic {
  Severity severity = Severity::kFault;  ///< for the map
  std::string text;                      ///< what is wrong, with the figures that show it
  std::string remedy;                    ///< what to do about it
};

/// "text: remedy".
inline std::string sentence(const CheckDiagnostic& diagnostic) {
  return diagnostic.text + ": " + diagnostic.remedy;
}

/// The report of an input: one line about its data, and its problems.
struct InputReport {
  std::string input;  ///< points, imu, velocity, gnss
  std::string found;  ///< the received data: rate, frame, fields or units, number of messages
  std::vector<CheckDiagnostic> diagnostics;  ///< its problems; empty if it is good
};

}  // namespace lidar_mapping::preprocessing
