// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::config {

/// One line for a key that no field has; suggests the nearest known name.
std::string unknown_key_problem(const std::string& key, const Value& value,
                                const std::vector<FieldDescription>& known,
                                const std::string& origin);
/// One line for two keys that are names of one field.
std::string twice_given_problem(const std::string& first, const std::string& second,
                                const std::string& origin);
/// One line for a value that its field refuses.
std::string bad_value_problem(const FieldDescription& field, const Value& value,
                              const std::string& problem, const std::string& origin);
/// A commented YAML file of fields with the given values (one for each field, as print_value()
/// writes it); `summary` is its heading.
std::string yaml_document(const std::string& summary, const std::vector<FieldDescription>& fields,
                          const std::vector<std::string>& values);
/// A Markdown table of fields: name, default, allowed values, unit, meaning.
std::string markdown_table(const std::vector<FieldDescription>& fields);

/// The fields of a configuration struct, in the order of its schema.
template <typename Config>
std::vector<FieldDescription> descriptions() {
  std::vector<FieldDescription> result;
  for (const auto& field : Config::schema().fields()) result.push_back(field.description);
  return result;
}

/// The configuration that `sources` give, later ones over earlier ones, defaults elsewhere. Throws
/// ConfigError with one line per unknown key, wrong type, value out of range and failed check.
template <typename Config>
Config load(const std::vector<Source>& sources) {
  const Schema<Config>& schema = Config::schema();
  Config config;
  std::vector<std::string> problems;
  for (const Source& source : sources) {
    std::map<std::string, std::string> given;  // name of the field to the key that set it
    for (const auto& [key, value] : flattened(source.values)) {
      const auto alias = schema.aliases().find(key);
      const std::string& name = alias == schema.aliases().end() ? key : alias->second;
      const auto [earlier, first] = given.emplace(name, key);
      if (!first) {
        problems.push_back(twice_given_problem(earlier->second, key, source.origin));
      }
      const typename Schema<Config>::Field* known = nullptr;
      for (const auto& field : schema.fields()) {
        if (field.description.name == name) known = &field;
      }
      if (known == nullptr) {
        problems.push_back(unknown_key_problem(key, value, descriptions<Config>(), source.origin));
        continue;
      }
      const std::string problem = known->read(config, value);
      if (!problem.empty()) {
        problems.push_back(bad_value_problem(known->description, value, problem, source.origin));
      }
    }
  }
  for (const auto& check : schema.checks()) {
    const std::string problem = check(config);
    if (!problem.empty()) problems.push_back(schema.stage() + ": " + problem);
  }
  if (!problems.empty()) throw ConfigError(joined(problems, "\n"));
  return config;
}

/// The configuration in a YAML file. Throws as read_yaml_file() and load() do.
template <typename Config>
Config load_file(const std::string& path) {
  return load<Config>({read_yaml_file(path)});
}

/// All fields as they are in force, as a commented YAML document.
template <typename Config>
std::string to_yaml(const Config& config) {
  std::vector<std::string> values;
  for (const auto& field : Config::schema().fields()) values.push_back(field.print(config));
  return yaml_document(Config::schema().summary(), descriptions<Config>(), values);
}

/// The table of all fields in doc/parameters.md.
template <typename Config>
std::string to_markdown() {
  return markdown_table(descriptions<Config>());
}

}  // namespace lidar_mapping::config
