#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <utility>

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

}  // namespace lidar_mapping::simulation
