// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/parameters.hpp"

#include <cmath>
#include <cstdlib>
#include <regex>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/overlay.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// The groups into which launch files load overlays, in growing priority.
const std::vector<std::string> kOverlays = {"overlays/sensor", "overlays/preset"};
const char* const kEffective = "effective_configuration";

config::Value from_word(const std::string& word) {
  static const std::regex number(R"([-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+)");
  if (std::regex_match(word, number)) {
    const double value = std::strtod(word.c_str(), nullptr);
    if (std::isfinite(value)) return {value};  // 1e999 is refused by the parameter, as a word
  }
  return {word};
}

config::Value from_list(XmlRpc::XmlRpcValue& value) {
  config::Value::List list;
  for (int i = 0; i < value.size(); ++i) list.push_back(from_xmlrpc(value[i]));
  return {list};
}

config::Value from_group(XmlRpc::XmlRpcValue& value) {
  config::Value::Map map;
  for (auto& entry : value) map[entry.first] = from_xmlrpc(entry.second);
  return {map};
}

/// The parameters of that name on the server, or an empty group.
config::Source source_at(const ros::NodeHandle& node, const std::string& name) {
  XmlRpc::XmlRpcValue values;
  const std::string origin = node.resolveName(name);
  if (!node.getParam(origin, values) || values.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
    return {origin, {config::Value::Map{}}};
  }
  return {origin, from_xmlrpc(values)};
}

}  // namespace

config::Value from_xmlrpc(const XmlRpc::XmlRpcValue& constant) {
  XmlRpc::XmlRpcValue value = constant;  // its accessors are not const
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return {static_cast<bool>(value)};
    case XmlRpc::XmlRpcValue::TypeInt:
      return {static_cast<int>(value)};
    case XmlRpc::XmlRpcValue::TypeDouble:
      return {static_cast<double>(value)};
    case XmlRpc::XmlRpcValue::TypeString:
      return from_word(static_cast<std::string>(value));
    case XmlRpc::XmlRpcValue::TypeArray:
      return from_list(value);
    case XmlRpc::XmlRpcValue::TypeStruct:
      return from_group(value);
    case XmlRpc::XmlRpcValue::TypeInvalid:
      return {};
    default:
      throw ConfigError("a parameter holds binary data or a date; give text or numbers");
  }
}

// The commands know the stages themselves; a test (test_node_parameters.cpp) compares.
std::vector<std::string> overlay_groups() {
  return {"nodes",        "back_end", "floor_detection", "front_end",
          "loop_closing", "map",      "preprocessing"};
}

std::vector<config::Source> parameter_sources(const ros::NodeHandle& node,
                                              const ros::NodeHandle& private_node,
                                              const std::string& stage) {
  std::vector<config::Source> of_nodes{source_at(node, "nodes")};
  std::vector<config::Source> of_stage{source_at(private_node, "")};
  for (const std::string& name : kOverlays) {
    const config::Source overlay = source_at(node, name);
    config::check_groups(overlay, overlay_groups());
    if (auto nodes = config::part_of(overlay, "nodes")) of_nodes.push_back(std::move(*nodes));
    if (auto values = config::part_of(overlay, stage)) of_stage.push_back(std::move(*values));
  }
  of_nodes.insert(of_nodes.end(), of_stage.begin(), of_stage.end());
  return of_nodes;
}

void publish_effective_configuration(const ros::NodeHandle& node, const std::string& stage,
                                     const std::string& yaml) {
  node.setParam(std::string(kEffective) + "/" + stage, yaml);
}

std::map<std::string, std::string> effective_configurations(const ros::NodeHandle& node) {
  std::map<std::string, std::string> texts;
  for (const auto& [stage, yaml] : config::flattened(source_at(node, kEffective).values)) {
    texts[stage] = config::to_string(yaml);
  }
  return texts;
}

}  // namespace lidar_mapping::ros_border
