// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/config/value.hpp"

// Overlays have a group of values for each stage, and priority over the files of the stages.
namespace lidar_mapping::config {

/// Throws ConfigError if the overlay has something else than groups of these names.
void check_groups(const Source& overlay, const std::vector<std::string>& names);

/// The group of that name, if the overlay has one.
std::optional<Source> part_of(const Source& overlay, const std::string& name);

/// One line for a value of `origin` that is in force in the place of `earlier` of `earlier_origin`.
std::string replaced_value_line(const std::string& name, const std::string& value,
                                const std::string& origin, const std::string& earlier,
                                const std::string& earlier_origin);

/// One line for each value of a source that an earlier source has set to another one, unless that
/// was the default: whoever wrote it expects that it is in force. Values that no field takes are
/// left to load(), which throws for them.
template <typename Config>
std::vector<std::string> replaced_values(const std::vector<Source>& sources) {
  const Schema<Config>& schema = Config::schema();
  std::vector<std::string> lines;
  for (const auto& field : schema.fields()) {
    const FieldDescription& known = field.description;
    std::string earlier = known.default_value;
    std::string earlier_origin;
    for (const Source& source : sources) {
      for (const auto& [key, value] : flattened(source.values)) {
        const auto alias = schema.aliases().find(key);
        if ((alias == schema.aliases().end() ? key : alias->second) != known.name) continue;
        Config config;
        if (!field.read(config, value).empty()) continue;
        const std::string text = field.print(config);
        if (earlier != known.default_value && text != earlier) {
          lines.push_back(
              replaced_value_line(known.name, text, source.origin, earlier, earlier_origin));
        }
        earlier = text;
        earlier_origin = source.origin;
      }
    }
  }
  return lines;
}

}  // namespace lidar_mapping::config
