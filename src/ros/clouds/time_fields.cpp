// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/time_fields.hpp"

#include <cmath>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

namespace {

using sensor_msgs::PointField;

/// Names of the two halves of a time begin alike and end so.
struct Halves {
  const char* first;   ///< end of the name of the larger part
  const char* second;  ///< end of the name of the smaller part
  double first_scale;
  double second_scale;
};
constexpr double kWord = 4294967296.0;  // of a half of 64 bits: 2^32, by definition
constexpr std::array<Halves, 12> kHalves = {{{"sec", "nsec", 1.0, 1e-9},
                                             {"sec", "nanosec", 1.0, 1e-9},
                                             {"sec", "usec", 1.0, 1e-6},
                                             {"secs", "nsecs", 1.0, 1e-9},
                                             {"second", "nanosecond", 1.0, 1e-9},
                                             {"seconds", "nanoseconds", 1.0, 1e-9},
                                             {"seconds", "microseconds", 1.0, 1e-6},
                                             {"_s", "_ns", 1.0, 1e-9},
                                             {"_s", "_us", 1.0, 1e-6},
                                             {"_h", "_l", kWord, 1.0},
                                             {"_hi", "_lo", kWord, 1.0},
                                             {"_high", "_low", kWord, 1.0}}};

/// The common beginning of the names of a time: none, "t", "time_", "timestamp" ...
bool begins_a_time(const std::string& name) {
  return name.empty() || name == "t" || name == "t_" || name.find("time") != std::string::npos ||
         name.find("stamp") != std::string::npos;
}

/// The name without its end; empty if it has another one.
std::optional<std::string> beginning(const std::string& name, const std::string& end) {
  if (name.size() < end.size()) return std::nullopt;
  const std::size_t length = name.size() - end.size();
  if (name.compare(length, end.size(), end) != 0) return std::nullopt;
  return name.substr(0, length);
}

std::optional<TimeFields> find_halves(const CloudView& message, const Halves& halves) {
  for (const PointField& field : message.fields) {
    const auto begin = beginning(lower_case(field.name), halves.first);
    if (!begin || !begins_a_time(*begin)) continue;
    const PointField* second = find_field_in_any_case(message, *begin + halves.second);
    if (second == nullptr) continue;
    return TimeFields{find_field(message, field.name), second, halves.first_scale,
                      halves.second_scale, halves.first_scale == 1.0};
  }
  return std::nullopt;
}

}  // namespace

std::string TimeFields::name() const {
  return second == nullptr ? first->name : first->name + " + " + second->name;
}

std::optional<TimeFields> time_fields(const CloudView& message) {
  for (const Halves& halves : kHalves) {
    if (const auto found = find_halves(message, halves)) return found;
  }
  const PointField* field = find_any_field(message, kTimeNames);
  if (field == nullptr) return std::nullopt;
  return TimeFields{field};
}

double number_of_type(std::uint8_t datatype, const std::uint8_t* address) {
  double result = 0.0;
  with_reader(datatype, [&](const auto& number) { result = static_cast<double>(number(address)); });
  return result;
}

double time_base(const CloudView& message, const TimeFields& fields) {
  if (fields.second == nullptr) return 0.0;
  const std::uint8_t* first = message.first + fields.first->offset;
  const double base = number_of_type(fields.first->datatype, first) * fields.first_scale;
  return std::isfinite(base) ? base : 0.0;
}

}  // namespace lidar_mapping::ros_border
