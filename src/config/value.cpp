// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/config/value.hpp"

#include <cmath>
#include <cstring>
#include <iterator>
#include <sstream>

#include <yaml-cpp/yaml.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/text.hpp"

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

/// A document becomes values; what only an attack or a damaged file has ends it: an alias that
/// contains itself, groups in groups without end.
class Conversion {
 public:
  Value value_from(const YAML::Node& node) {
    if (++values_ > kMostValues) fail(node, "it has too many values");
    if (node.IsScalar()) return scalar_from(node);
    if (!node.IsSequence() && !node.IsMap()) return {};
    if (++depth_ > kDeepest) fail(node, "its groups are nested too deeply");
    const Value value = node.IsSequence() ? Value{list_from(node)} : Value{map_from(node)};
    --depth_;
    return value;
  }

 private:
  // Chosen: far above any file of parameters; aliases could multiply values without end.
  static constexpr int kMostValues = 100'000;
  static constexpr int kDeepest = 30;  // levels; chosen: far above any file of parameters

  [[noreturn]] static void fail(const YAML::Node& node, const std::string& problem) {
    throw YAML::ParserException(node.Mark(), problem);
  }

  Value::List list_from(const YAML::Node& node) {
    Value::List list;
    for (const YAML::Node& element : node) list.push_back(value_from(element));
    return list;
  }

  Value::Map map_from(const YAML::Node& node) {
    Value::Map map;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) fail(entry.first, "the name of a value is to be one word");
      map[entry.first.Scalar()] = value_from(entry.second);
    }
    return map;
  }

  int values_ = 0;
  int depth_ = 0;
};

[[noreturn]] void refuse(const std::string& origin, std::size_t line, const std::string& problem) {
  throw ConfigError(origin + ":" + std::to_string(line) + ": " + problem +
                    "; see config/ for how such a file looks");
}

/// The parser calls itself for every bracket that is open and every column of indentation, and ends
/// with the stack where somebody writes ten thousand of them.
void check_nesting(const std::string& text, const std::string& origin) {
  constexpr std::size_t kLargest = 1'000'000;  // bytes; chosen: far above any file of parameters
  // Brackets; chosen: far above any list, far below the end of the stack.
  constexpr std::size_t kMostOpen = 100;
  // Columns of indentation and indicators; chosen: wider than a line of a screen.
  constexpr std::size_t kWidest = 200;
  if (text.size() > kLargest) refuse(origin, 1, "it is larger than a file of parameters is");
  std::size_t line = 1, open = 0, indentation = 0;
  bool in_front = true;
  for (const char c : text) {
    if (c == '\0') refuse(origin, line, "it has a zero byte, so it is no text");
    if (c == '\n') ++line;
    in_front = c == '\n' || (in_front && std::strchr(" -?:!&*[{", c) != nullptr);
    indentation = c == '\n' ? 0 : indentation + (in_front ? 1 : 0);
    if (c == '[' || c == '{') ++open;
    if ((c == ']' || c == '}') && open > 0) --open;
    if (open > kMostOpen || indentation > kWidest) {
      refuse(origin, line, "it is nested too deeply for parameters");
    }
  }
}

Source source_from(const YAML::Node& root, const std::string& origin) {
  if (root.IsNull()) return {origin, {Value::Map{}}};
  if (!root.IsMap()) {
    throw ConfigError(origin + ": expected lines of the form 'key: value'");
  }
  return {origin, Conversion().value_from(root)};
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
  std::ifstream file = open_for_reading(path);
  return parse_yaml({std::istreambuf_iterator<char>(file), {}}, path);
}

/// YAML::Exception is not only of the parser: also of what it made, where that has no sense.
Source parse_yaml(const std::string& text, const std::string& origin) {
  check_nesting(text, origin);
  try {
    return source_from(YAML::Load(text), origin);
  } catch (const YAML::Exception& error) {
    const bool has_line = !error.mark.is_null();
    refuse(origin, has_line ? static_cast<std::size_t>(error.mark.line) + 1 : 1, error.msg);
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
      std::vector<std::string> texts;
      for (const Value& element : list) texts.push_back(to_string(element));
      return "[" + joined(texts) + "]";
    }
    std::string operator()(const Value::Map&) const { return "a group"; }
  };
  return std::visit(Printer{}, value.data);
}

}  // namespace lidar_mapping::config
