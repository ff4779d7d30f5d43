// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/config/overlay.hpp"

#include <algorithm>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::config {

void check_groups(const Source& overlay, const std::vector<std::string>& names) {
  const auto* groups = std::get_if<Value::Map>(&overlay.values.data);
  if (groups == nullptr) return;
  for (const auto& [name, group] : *groups) {
    if (std::count(names.begin(), names.end(), name) > 0) continue;
    throw ConfigError(overlay.origin + ": no stage has the name '" + name +
                      "'; an overlay has groups of the names " + joined(names));
  }
}

std::optional<Source> part_of(const Source& overlay, const std::string& name) {
  const auto* groups = std::get_if<Value::Map>(&overlay.values.data);
  if (groups == nullptr || groups->count(name) == 0) return std::nullopt;
  return Source{overlay.origin, groups->at(name)};
}

std::string replaced_value_line(const std::string& name, const std::string& value,
                                const std::string& origin, const std::string& earlier,
                                const std::string& earlier_origin) {
  return name + ": " + value + " of " + origin + " is in force, not " + earlier + " of " +
         earlier_origin;
}

}  // namespace lidar_mapping::config
