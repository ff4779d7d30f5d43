// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::simulation {

/// A row of a table of faults.
template <typename Kind>
struct FaultDescription {
  const char* name;
  Kind kind;
  const char* format;  ///< How it is written, with the range of its value.
  double min;          ///< Least value.
  double max;          ///< Largest value.
};

/// Reads all numbers of a text of this sscanf format, which has to end with %n; false if the text
/// has another form or any rest.
template <typename... Numbers>
bool matches_format(const std::string& text, const char* format, Numbers*... numbers) {
  int end = 0;
  const int read = std::sscanf(text.c_str(), format, numbers..., &end);
  return read == static_cast<int>(sizeof...(numbers)) && end == static_cast<int>(text.size());
}

/// Reads the value of a fault, or "VALUE,OTHER" where it may have another number; false if the text
/// has another form or the value lies outside of its range. The range of the other is not checked.
template <typename Kind>
bool read_numbers(const std::string& text, const FaultDescription<Kind>& known, double& value,
                  double* other) {
  const bool fits = matches_format(text, "%lf%n", &value) ||
                    (other != nullptr && matches_format(text, "%lf,%lf%n", &value, other));
  return fits && value >= known.min && value <= known.max;  // written so that NaN fails
}

/// How the faults in a table are written, with the ranges of their values.
template <typename Descriptions>
std::vector<std::string> fault_formats(const Descriptions& descriptions) {
  std::vector<std::string> formats;
  for (const auto& known : descriptions) formats.emplace_back(known.format);
  return formats;
}

/// Parses a fault of a table; `read_value` reads the text behind the equals sign, if there is one,
/// into a fault of this kind. Throws ConfigError for any other text.
template <typename Fault, typename Descriptions, typename ReadValue>
Fault parse_fault(const std::string& text, const Descriptions& descriptions,
                  const ReadValue& read_value) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  std::optional<std::string> value;
  if (equals != std::string::npos) value = text.substr(equals + 1);
  for (const auto& known : descriptions) {
    if (name != known.name) continue;
    Fault fault;
    fault.kind = known.kind;
    if (read_value(known, value, fault)) return fault;
    throw ConfigError("fault: '" + text + "' is not of the form " + known.format);
  }
  std::string names;
  for (const auto& known : descriptions) names += std::string(" ") + known.name;
  throw ConfigError("fault: '" + name + "' is unknown; use one of" + names);
}

}  // namespace lidar_mapping::simulation
