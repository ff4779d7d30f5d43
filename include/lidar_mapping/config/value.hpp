// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

namespace lidar_mapping::config {

/// A configuration value as it came from a YAML file or from the parameter server: nothing, a
/// scalar, a list or a map.
struct Value {
  using List = std::vector<Value>;           ///< in the order of the file
  using Map = std::map<std::string, Value>;  ///< by keys
  /// The one of these that it is; std::monostate is nothing.
  std::variant<std::monostate, bool, int, double, std::string, List, Map> data;
};

/// Where values came from, for messages, and the values: a map.
struct Source {
  std::string origin;  ///< name of the file or of the parameter namespace
  Value values;        ///< a map
};

/// Reads a YAML file. Throws FileError if it cannot be read and ConfigError if it is no YAML map.
Source read_yaml_file(const std::string& path);
/// The same from text, with ConfigError alone; `origin` is used in messages.
Source parse_yaml(const std::string& text, const std::string& origin);

/// The leaves of nested maps under names joined by '/': {a: {b: 1}} gives {"a/b": 1}.
std::map<std::string, Value> flattened(const Value& values);

/// As a person would write it: true, 1, 0.5, word, [1, 2].
std::string to_string(const Value& value);

}  // namespace lidar_mapping::config
