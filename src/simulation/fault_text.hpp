// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::simulation {

/// The name of a fault and what stands behind its equals sign.
inline std::pair<std::string, std::optional<std::string>> split_fault(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, std::nullopt};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// True if all of the text has this form, whose last word is %n, and gives all of these numbers.
template <typename... Numbers>
bool reads(const std::string& text, const char* form, Numbers*... numbers) {
  int end = 0;
  const int read = std::sscanf(text.c_str(), form, numbers..., &end);
  return read == static_cast<int>(sizeof...(numbers)) && end == static_cast<int>(text.size());
}

/// The names in a table of faults.
template <typename Descriptions>
std::vector<std::string> fault_names(const Descriptions& descriptions) {
  std::vector<std::string> names;
  for (const auto& known : descriptions) names.emplace_back(known.name);
  return names;
}

/// The fault that a text names, of those in a table (`name` and `form` of each): `usual` gives it
/// without a value, `read_value` reads that into it. Throws ConfigError for any other text.
template <typename Descriptions, typename Usual, typename ReadValue>
auto parse_fault(const std::string& text, const Descriptions& descriptions, const Usual& usual,
                 const ReadValue& read_value) {
  const auto [name, value] = split_fault(text);
  for (const auto& known : descriptions) {
    if (name != known.name) continue;
    auto fault = usual(known);
    if (read_value(known, value, fault)) return fault;
    throw ConfigError("fault: '" + text + "' is not of the form " + known.form);
  }
  std::string names;
  for (const std::string& known : fault_names(descriptions)) names += " " + known;
  throw ConfigError("fault: '" + name + "' is unknown; use one of" + names);
}

}  // namespace lidar_mapping::simulation
