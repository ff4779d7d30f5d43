// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "clouds/point_fields.hpp"

namespace lidar_mapping::ros_border {

/// Where the time of a point stands: in a field, or in two that have to be added.
struct TimeFields {
  const sensor_msgs::PointField* first = nullptr;   ///< the time, or the larger part of it
  const sensor_msgs::PointField* second = nullptr;  ///< the smaller part; null if there is none
  double first_scale = 1.0;                         ///< unit of the first field
  double second_scale = 0.0;                        ///< unit of the second field
  bool is_in_seconds = false;  ///< the sum is in seconds; else its unit is not known

  /// "t", or "time_sec + time_nsec".
  std::string name() const;
};

/// The fields of the points' times, by their names in any case; none if there are no times. Throws
/// InputError if one lies outside of the point.
std::optional<TimeFields> time_fields(const CloudView& message);

/// The number of that type at an address.
double number_of_type(std::uint8_t datatype, const std::uint8_t* address);

/// The larger part of the first point's time, from which those of all points are counted, so that
/// they keep their digits; 0 for a time in one field, and where it is not finite.
double time_base(const CloudView& message, const TimeFields& fields);

/// Calls body(time, index) for every point, with the time minus `base`.
template <typename Body>
void for_each_time(const CloudView& message, const TimeFields& fields, double base,
                   const Body& body) {
  const sensor_msgs::PointField& first = *fields.first;
  if (fields.second == nullptr) {
    return with_reader(first.datatype, [&](const auto& number) {
      for_each_point(message, [&](const std::uint8_t* in, std::size_t i) {
        body(static_cast<double>(number(in + first.offset)), i);
      });
    });
  }
  const sensor_msgs::PointField& second = *fields.second;
  for_each_point(message, [&](const std::uint8_t* in, std::size_t i) {
    const double whole =
        number_of_type(first.datatype, in + first.offset) * fields.first_scale - base;
    body(whole + number_of_type(second.datatype, in + second.offset) * fields.second_scale, i);
  });
}

}  // namespace lidar_mapping::ros_border
