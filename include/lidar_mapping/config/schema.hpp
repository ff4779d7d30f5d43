// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/config/value.hpp"

namespace lidar_mapping::config {

/// Allowed values of a number, both ends included.
struct Range {
  double min = -std::numeric_limits<double>::infinity();  ///< least value, in the unit of files
  double max = std::numeric_limits<double>::infinity();   ///< greatest value, in the unit of files
};

/// What a person has to know about one field.
struct FieldDescription {
  std::string name;           ///< '/' separates groups
  std::string default_value;  ///< as written in a YAML file
  std::string allowed;        ///< type and range or choices, in words
  std::string unit;           ///< empty if there is none
  std::string meaning;        ///< one sentence
};

// Conversions of a value to a field's type. They return what is wrong, as the end of a sentence
// ("is out of range"), and leave the field as it is then; or an empty text.

/// Reads a number, whole or not, or three times the same one, within the range.
std::string read_value(const Value& value, const Range& range, double& field);
/// Reads an angle in degrees, or in degrees for every `distance` (m), within the range in the same
/// unit; the field is in rad or rad/m.
std::string read_angle(const Value& value, const Range& range, double distance, double& field);
/// Reads a whole number within the range.
std::string read_value(const Value& value, const Range& range, int& field);
/// Reads true or false.
std::string read_value(const Value& value, bool& field);
/// Reads a text; nothing counts as an empty one.
std::string read_value(const Value& value, std::string& field);
/// Reads a list of exactly `size` finite numbers.
std::string read_value(const Value& value, std::size_t size, std::vector<double>& field);

// Values as a YAML file has them: read back they have the same type, and numbers 12 digits.

/// A number, always with a point, an exponent or as .inf, -.inf, .nan.
std::string print_value(double field);
/// An angle in rad or rad/m as read_angle() reads it.
std::string print_angle(double field, double distance);
/// A whole number.
std::string print_value(int field);
/// true or false.
std::string print_value(bool field);
/// A text in quotation marks, with a backslash before those that it holds and before its own.
std::string print_value(const std::string& field);
/// A list: [1.0, 2.0].
std::string print_value(const std::vector<double>& field);

/// Allowed values in words: "integer from 1 to 256"; the type alone if it has no limits.
std::string describe(const char* type, const Range& range);
/// The distance (m) in a unit that files have for angles: 100 in "deg per 100 m", 1 in "deg/m" and,
/// because there is none to divide by, in "deg". Throws InputError for other units.
double distance_of_angle_unit(const std::string& unit);
/// Allowed words: "NDT, ICP or GICP". Words that differ by capital letters alone are named once.
std::string describe_choices(const std::vector<std::string>& choices);

/// The one description of a configuration struct: loading, checking, printing, the default file in
/// config/ and the table in doc/parameters.md all follow from it. Defaults are those of a
/// default-constructed `Config`. A configuration struct offers it as `static const Schema<Config>&
/// schema()`.
template <typename Config>
class Schema {
 public:
  /// `stage` names the file config/STAGE.yaml; `summary` is its heading.
  Schema(std::string stage, std::string summary)
      : stage_(std::move(stage)), summary_(std::move(summary)) {}

  /// A field with a real number. `name` is that in files; `unit` may be empty; `meaning` is one
  /// sentence.
  Schema& real(const std::string& name, double Config::*field, Range range, const std::string& unit,
               const std::string& meaning) {
    return add_value({name, "", describe("real number", range), unit, meaning}, field, range);
  }
  /// A field with an angle in rad, or with an angle per distance in rad/m. Files, messages and
  /// `range` have it in `unit`: "deg", "deg/m" or "deg per 100 m".
  Schema& angle(const std::string& name, double Config::*field, Range range,
                const std::string& unit, const std::string& meaning) {
    const double distance = distance_of_angle_unit(unit);
    return add(
        {name, "", describe("real number", range), unit, meaning},
        [=](Config& c, const Value& v) { return read_angle(v, range, distance, c.*field); },
        [=](const Config& c) { return print_angle(c.*field, distance); });
  }
  /// A field with a whole number.
  Schema& integer(const std::string& name, int Config::*field, Range range, const std::string& unit,
                  const std::string& meaning) {
    return add_value({name, "", describe("integer", range), unit, meaning}, field, range);
  }
  /// A field that is true or false.
  Schema& boolean(const std::string& name, bool Config::*field, const std::string& meaning) {
    return add_value({name, "", "true or false", "", meaning}, field);
  }
  /// A field with any text.
  Schema& text(const std::string& name, std::string Config::*field, const std::string& meaning) {
    return add_value({name, "", "text", "", meaning}, field);
  }
  /// A list of exactly `size` numbers.
  Schema& reals(const std::string& name, std::vector<double> Config::*field, std::size_t size,
                const std::string& unit, const std::string& meaning) {
    return add_value({name, "", "list of " + std::to_string(size) + " numbers", unit, meaning},
                     field, size);
  }
  /// One of several words, each standing for a value of an enumeration.
  template <typename Enum>
  Schema& choice(const std::string& name, Enum Config::*field,
                 const std::vector<std::pair<std::string, Enum>>& choices,
                 const std::string& meaning) {
    std::vector<std::string> names;
    for (const auto& entry : choices) names.push_back(entry.first);
    const auto print = [=](const Config& c) {
      for (const auto& entry : choices) {
        if (entry.second == c.*field) return entry.first;
      }
      return std::string();
    };
    const auto read = [=](Config& c, const Value& v) {
      std::string word;
      std::string problem = read_value(v, word);
      if (!problem.empty()) return problem;
      for (const auto& entry : choices) {
        if (entry.first != word) continue;
        c.*field = entry.second;
        return std::string();
      }
      return std::string("is none of the choices");
    };
    return add({name, "", describe_choices(names), "", meaning}, read, print);
  }
  /// All fields of a part, under `prefix` ("" or "group/").
  template <typename Part>
  Schema& include(Part Config::*part, const Schema<Part>& schema, const std::string& prefix = "") {
    for (const auto& entry : schema.fields()) {
      FieldDescription description = entry.description;
      description.name = prefix + description.name;
      add(
          std::move(description),
          [=, read = entry.read](Config& c, const Value& v) { return read(c.*part, v); },
          [=, print = entry.print](const Config& c) { return print(c.*part); });
    }
    for (const auto& [other, name] : schema.aliases()) aliases_[prefix + other] = prefix + name;
    for (const auto& check : schema.checks()) {
      checks_.push_back([=](const Config& c) { return check(c.*part); });
    }
    return *this;
  }
  /// Another name under which files of other programs know the field `name`; read, never written.
  Schema& alias(const std::string& other, const std::string& name) {
    aliases_[other] = name;
    return *this;
  }
  /// A condition between fields: returns what is wrong and how to correct it, or an empty text.
  Schema& check(std::function<std::string(const Config&)> condition) {
    checks_.push_back(std::move(condition));
    return *this;
  }

  /// A field, with the functions that move its value.
  struct Field {
    FieldDescription description;  ///< for people
    /// Sets the field from a value; returns what is wrong, or an empty text.
    std::function<std::string(Config&, const Value&)> read;
    std::function<std::string(const Config&)> print;  ///< its value as a YAML file has it
  };
  /// The name that was given to the constructor.
  const std::string& stage() const { return stage_; }
  /// The heading that was given to the constructor.
  const std::string& summary() const { return summary_; }
  /// All fields, in the order in which they were added.
  const std::vector<Field>& fields() const { return fields_; }
  /// What alias() has added: other name to name.
  const std::map<std::string, std::string>& aliases() const { return aliases_; }
  /// What check() has added.
  const std::vector<std::function<std::string(const Config&)>>& checks() const { return checks_; }

 private:
  /// A field that read_value(value, limits..., field) reads and print_value(field) prints.
  template <typename Type, typename... Limits>
  Schema& add_value(FieldDescription description, Type Config::*field, const Limits&... limits) {
    return add(
        std::move(description),
        [=](Config& c, const Value& v) { return read_value(v, limits..., c.*field); },
        [=](const Config& c) { return print_value(c.*field); });
  }
  /// Its default is that of a default-constructed `Config`.
  Schema& add(FieldDescription description, std::function<std::string(Config&, const Value&)> read,
              std::function<std::string(const Config&)> print) {
    description.default_value = print(Config{});
    fields_.push_back({std::move(description), std::move(read), std::move(print)});
    return *this;
  }

  std::string stage_;
  std::string summary_;
  std::vector<Field> fields_;
  std::map<std::string, std::string> aliases_;
  std::vector<std::function<std::string(const Config&)>> checks_;
};

}  // namespace lidar_mapping::config
