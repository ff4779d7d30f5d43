#include "lidar_mapping/config/value.hpp"

#include <cmath>
#include <sstream>

#include <yaml-cpp/yaml.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"

namespace lidar_mapping::config {

namespace {

Value scalar_from(const YAML::Node& node) {
  if (node.Tag() == "!") return {node.Scalar()};  // quoted
  int integer = 0;
  if (YAML::convert<int>::decode(node, integer)) return {integer};
  double real = 0.0;
  if (YAML::convert<double>::decode(node, real)) return {real};
  const std::string& word = node.Scalar();
  if (word == "true" || word == "True") return {true};
  if (word == "false" || word == "False") return {false};
  return {word};
}

Value value_from(const YAML::Node& node) {
  if (node.IsScalar()) return scalar_from(node);
  if (node.IsSequence()) {
    Value::List list;
    for (const YAML::Node& element : node) list.push_back(value_from(element));
    return {list};
  }
  if (node.IsMap()) {
    Value::Map map;
    for (const auto& entry : node) map[entry.first.as<std::string>()] = value_from(entry.second);
    return {map};
  }
  return {};
}

Source source_from(const YAML::Node& root, const std::string& origin) {
  if (root.IsNull()) return {origin, {Value::Map{}}};
  if (!root.IsMap()) {
    throw ConfigError(origin + ": expected lines of the form 'key: value'");
  }
  return {origin, value_from(root)};
}

void flatten(const std::string& prefix, const Value& value, std::map<std::string, Value>& leaves) {
  if (const auto* map = std::get_if<Value::Map>(&value.data)) {
    for (const auto& [key, child] : *map) {
      flatten(prefix.empty() ? key : prefix + "/" + key, child, leaves);
    }
  } else {
    leaves[prefix] = value;
  }
}

}  // namespace

Source read_yaml_file(const std::string& path) {
  try {
    std::ifstream file = open_for_reading(path);
    return source_from(YAML::Load(file), path);
  } catch (const YAML::ParserException& error) {
    throw ConfigError(path + ": " + error.what());
  }
}

Source parse_yaml(const std::string& text, const std::string& origin) {
  try {
    return source_from(YAML::Load(text), origin);
  } catch (const YAML::ParserException& error) {
    throw ConfigError(origin + ": " + error.what());
  }
}

std::map<std::string, Value> flattened(const Value& values) {
  std::map<std::string, Value> leaves;
  if (std::holds_alternative<Value::Map>(values.data)) flatten("", values, leaves);
  return leaves;
}

std::string to_string(const Value& value) {
  struct Printer {
    std::string operator()(std::monostate) const { return "nothing"; }
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(int number) const { return std::to_string(number); }
    std::string operator()(double number) const {
      if (std::isinf(number)) return number > 0 ? ".inf" : "-.inf";
      if (std::isnan(number)) return ".nan";
      std::ostringstream text;
      text.precision(12);
      text << number;
      return text.str();
    }
    std::string operator()(const std::string& word) const { return word; }
    std::string operator()(const Value::List& list) const {
      std::string text;
      for (const Value& element : list) {
        text += (text.empty() ? "" : ", ") + to_string(element);
      }
      return "[" + text + "]";
    }
    std::string operator()(const Value::Map&) const { return "a group"; }
  };
  return std::visit(Printer{}, value.data);
}

}  // namespace lidar_mapping::config
