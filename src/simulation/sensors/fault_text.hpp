// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::simulation {

/// Splits a fault into its name and the value behind the equals sign.
inline std::pair<std::string, std::optional<std::string>> split_fault(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, std::nullopt};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// Reads all numbers of a text of this sscanf format, which has to end with %n; false if the text
/// has another form or any rest.
template <typename... Numbers>
bool matches_format(const std::string& text, const char* format, Numbers*... numbers) {
  int end = 0;
  const int read = std::sscanf(text.c_str(), format, numbers..., &end);
  return read == static_cast<int>(sizeof...(numbers)) && end == static_cast<int>(text.size());
}

/// Names in a table of faults.
template <typename Descriptions>
std::vector<std::string> fault_names(const Descriptions& descriptions) {
  std::vector<std::string> names;
  for (const auto& known : descriptions) names.emplace_back(known.name);
  return names;
}

/// How the faults in a table are written, with the ranges of their values.
template <typename Descriptions>
std::vector<std::string> fault_formats(const Descriptions& descriptions) {
  std::vector<std::string> formats;
  for (const auto& known : descriptions) formats.emplace_back(known.format);
  return formats;
}

/// Parses a fault of a table (with `name` and `form` of each): `default_fault` creates it without a
/// value, and `read_value` reads the value into it. Throws ConfigError for any other text.
template <typename Descriptions, typename MakeDefault, typename ReadValue>
auto parse_fault(const std::string& text, const Descriptions& descriptions,
                 const MakeDefault& default_fault, const ReadValue& read_value) {
  const auto [name, value] = split_fault(text);
  for (const auto& known : descriptions) {
    if (name != known.name) continue;
    auto fault = default_fault(known);
    if (read_value(known, value, fault)) return fault;
    throw ConfigError("fault: '" + text + "' is not of the form " + known.format);
  }
  std::string names;
  for (const std::string& known : fault_names(descriptions)) names += " " + known;
  throw ConfigError("fault: '" + name + "' is unknown; use one of" + names);
}

}  // namespace lidar_mapping::simulation
