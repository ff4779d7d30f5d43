// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/config/schema.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::config {

namespace {

/// Without those that differ from an earlier one by capital letters alone.
std::vector<std::string> unique_ignoring_case(const std::vector<std::string>& words) {
  std::vector<std::string> result;
  for (const std::string& word : words) {
    const auto is_same = [&](const std::string& other) {
      return lower_case(word) == lower_case(other);
    };
    if (std::none_of(result.begin(), result.end(), is_same)) result.push_back(word);
  }
  return result;
}

std::string check_range(double number, const Range& range) {
  if (std::isnan(number)) return "is not a number";
  return number < range.min || number > range.max ? "is out of range" : "";
}

bool to_double(const Value& value, double& number) {
  if (const auto* integer = std::get_if<int>(&value.data)) {
    number = *integer;
    return true;
  }
  if (const auto* real = std::get_if<double>(&value.data)) {
    number = *real;
    return true;
  }
  return false;
}

}  // namespace

std::string read_value(const Value& value, const Range& range, double& field) {
  // lidar_localization gives the edge of a voxel three times: leaf_size: [0.6, 0.6, 0.6].
  if (const auto* list = std::get_if<Value::List>(&value.data)) {
    std::vector<double> edges;
    const std::string problem = read_value(value, 3, edges);
    if (!problem.empty()) return list->size() == 3 ? problem : "is not a number";
    if (edges[1] != edges[0] || edges[2] != edges[0]) return "has three different numbers";
    return read_value(Value{edges[0]}, range, field);
  }
  double number = 0.0;
  if (!to_double(value, number)) return "is not a number";
  const std::string problem = check_range(number, range);
  if (problem.empty()) field = number;
  return problem;
}

std::string read_angle(const Value& value, const Range& range, double distance, double& field) {
  double degrees = 0.0;
  const std::string problem = read_value(value, range, degrees);
  if (problem.empty()) field = degrees * kRadPerDeg / distance;
  return problem;
}

std::string read_value(const Value& value, const Range& range, int& field) {
  const auto* integer = std::get_if<int>(&value.data);
  if (integer == nullptr) return "is not an integer";
  const std::string problem = check_range(*integer, range);
  if (problem.empty()) field = *integer;
  return problem;
}

std::string read_value(const Value& value, bool& field) {
  const auto* flag = std::get_if<bool>(&value.data);
  if (flag == nullptr) return "is not true or false";
  field = *flag;
  return "";
}

std::string read_value(const Value& value, std::string& field) {
  if (std::holds_alternative<std::monostate>(value.data)) {
    field.clear();
    return "";
  }
  const auto* word = std::get_if<std::string>(&value.data);
  if (word == nullptr) return "is not a text";
  field = *word;
  return "";
}

std::string read_value(const Value& value, std::size_t size, std::vector<double>& field) {
  const auto* list = std::get_if<Value::List>(&value.data);
  if (list == nullptr) return "is not a list";
  if (list->size() != size) return "has " + std::to_string(list->size()) + " elements";
  std::vector<double> numbers(size);
  for (std::size_t i = 0; i < size; ++i) {
    if (!to_double((*list)[i], numbers[i]) || !std::isfinite(numbers[i])) {
      return "holds something that is not a finite number";
    }
  }
  field = std::move(numbers);
  return "";
}

std::string print_value(double field) {
  const std::string text = to_string(Value{field});
  // A number without a point would come back as an integer from the parameter server.
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string print_angle(double field, double distance) {
  // The twelve digits of print_value() are without the rounding errors of the conversions.
  return print_value(field * distance * kDegPerRad);
}

std::string print_value(int field) { return std::to_string(field); }

std::string print_value(bool field) { return field ? "true" : "false"; }

std::string print_value(const std::string& field) {
  std::string text;
  for (const char letter : field) {
    if (letter == '"' || letter == '\\') text += '\\';
    text += letter;
  }
  return '"' + text + '"';
}

std::string print_value(const std::vector<double>& field) {
  std::vector<std::string> texts;
  for (const double number : field) texts.push_back(print_value(number));
  return "[" + joined(texts) + "]";
}

std::string describe(const char* type, const Range& range) {
  const std::string low = to_string(Value{range.min});
  const std::string high = to_string(Value{range.max});
  if (std::isinf(range.min) && std::isinf(range.max)) return type;
  if (std::isinf(range.max)) return std::string(type) + " of at least " + low;
  if (std::isinf(range.min)) return std::string(type) + " of at most " + high;
  return std::string(type) + " from " + low + " to " + high;
}

double distance_of_angle_unit(const std::string& unit) {
  if (unit == "deg" || unit == "deg/m") return 1.0;
  if (unit == "deg per 100 m") return 100.0;
  throw InputError("'" + unit + "' is no unit of angles; use deg, deg/m or deg per 100 m");
}

std::string describe_choices(const std::vector<std::string>& names) {
  const std::vector<std::string> choices = unique_ignoring_case(names);
  std::string text;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (i > 0) text += i + 1 == choices.size() ? " or " : ", ";
    text += choices[i];
  }
  return text;
}

}  // namespace lidar_mapping::config
