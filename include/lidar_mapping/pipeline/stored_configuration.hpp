// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// The parameters of a stage that were in force when the session was recorded, as a source for
/// config::load(); empty if the session does not hold them. Parameters of the node (frames, queues)
/// are left out.
template <typename Config>
config::Source stored_configuration(const session::Session& session) {
  const std::string& stage = Config::schema().stage();
  const auto texts = session.configurations();
  const auto text = texts.find(stage);
  const std::string origin = (session.directory() / "config.yaml").string();
  if (text == texts.end()) return {origin, {config::Value::Map{}}};
  config::Value::Map known;
  const auto all = config::flattened(config::parse_yaml(text->second, origin).values);
  for (const auto& field : Config::schema().fields()) {
    const auto value = all.find(field.description.name);
    if (value != all.end()) known.insert(*value);
  }
  return {origin, {known}};
}

/// The same as a configuration, with defaults for what the session does not hold. Throws
/// ConfigError if a value is not allowed.
template <typename Config>
Config stored_config(const session::Session& session) {
  return config::load<Config>({stored_configuration<Config>(session)});
}

}  // namespace lidar_mapping::pipeline
