// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/point_times.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "clouds/point_fields.hpp"

namespace lidar_mapping::ros_border {

namespace {

using preprocessing::PointTimeUnit;
using sensor_msgs::PointField;

/// Limits of the time span of a scan relative to its period; outside of them the times have another
/// unit. Chosen: units differ by a thousand, and a sensor may see a part of a turn or turn at half
/// of the rate that is configured.
constexpr double kMinSpanRatio = 0.1;
constexpr double kMaxSpanRatio = 2.5;
/// Largest difference of absolute times of the same clock from the stamp, s. Chosen: longer than a
/// scan, shorter than clocks that were never set differ.
constexpr double kSameClock = 2.0;

struct Unit {
  const char* name;
  double seconds;
};
constexpr std::array<Unit, 4> kUnits = {{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};

/// Smallest and largest finite value of a field, in its own unit.
struct Bounds {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
};

Bounds bounds_of(const CloudView& message, const TimeFields& fields, double base) {
  Bounds bounds;
  for_each_time(message, fields, base, [&](double value, std::size_t) {
    if (!std::isfinite(value)) return;
    bounds.min = value < bounds.min ? value : bounds.min;
    bounds.max = value > bounds.max ? value : bounds.max;
  });
  return bounds;
}

std::optional<Unit> configured_unit(PointTimeUnit unit) {
  if (unit == PointTimeUnit::kAuto) return std::nullopt;
  return kUnits[static_cast<std::size_t>(unit) - 1];
}

/// The unit in which the times span about one turn of the LiDAR; if there is none, the usual one of
/// the type.
Unit unit_of(const TimeFields& fields, const Bounds& bounds,
             const preprocessing::PreprocessingConfig& config) {
  if (fields.is_in_seconds) return kUnits[0];
  if (const auto unit = configured_unit(config.point_time_unit)) return *unit;
  for (const Unit& unit : kUnits) {
    const double ratio = (bounds.max - bounds.min) * unit.seconds / config.scan_period;
    if (ratio > kMinSpanRatio && ratio < kMaxSpanRatio) return unit;
  }
  const std::uint8_t type = fields.first->datatype;
  const bool counts =
      size_of(type) >= 4 && type != PointField::FLOAT32 && type != PointField::FLOAT64;
  return counts ? kUnits[3] : kUnits[0];
}

/// How the counts of the fields become seconds: those from the base are counted from `origin`.
struct TimeScale {
  double base;    ///< see time_base()
  double origin;  ///< of the counts from the base
  double unit;    ///< s
  double shift;   ///< of the origin, s
};

/// Differences from a time near to them, so that absolute nanoseconds keep their digits.
void read_times(const CloudView& message, const TimeFields& fields, const TimeScale& scale,
                std::vector<float>& times) {
  for_each_time(message, fields, scale.base, [&](double value, std::size_t i) {
    times[i] = static_cast<float>((value - scale.origin) * scale.unit + scale.shift);
  });
}

/// `base` and `counts` (in the field's unit) minus the stamp, s. Whole seconds are subtracted
/// first.
double since_stamp(double base, double counts, double unit, const ros::Time& stamp) {
  const double per_second = std::round(1.0 / unit);
  double seconds = -static_cast<double>(stamp.sec);
  double rest = 0.0;
  for (const double part : {base, counts}) {
    const double beyond = std::fmod(part, per_second);
    seconds += std::round((part - beyond) / per_second);
    rest += beyond;
  }
  return seconds + (rest * unit - 1e-9 * stamp.nsec);
}

}  // namespace

void decode_times(const CloudView& message, const TimeFields& fields,
                  const preprocessing::PreprocessingConfig& config,
                  const std::optional<preprocessing::TimeSpan>& read, DecodedCloud& result) {
  std::vector<float>& times = result.scan.cloud.times;
  const double base = time_base(message, fields);
  const Bounds bounds = read ? Bounds{read->begin, read->end} : bounds_of(message, fields, base);
  if (!(bounds.max > bounds.min)) {  // the driver does not fill the fields
    times.clear();
    return;
  }
  const Unit unit = unit_of(fields, bounds, config);
  const double longest = kMaxSpanRatio * config.scan_period;
  const double first = (base + bounds.min) * unit.seconds;
  const double from_stamp = since_stamp(base, bounds.min, unit.seconds, message.header.stamp);
  CloudFormat& format = result.format;
  format.time_field = fields.name();
  format.time_unit = unit.name;
  const bool is_relative = std::abs(first) < longest;
  format.absolute_times = !is_relative && std::abs(from_stamp) < kSameClock;
  format.foreign_clock = !is_relative && !format.absolute_times;
  const double shift = is_relative ? first : format.absolute_times ? from_stamp : 0.0;
  result.scan.times_are_absolute = format.absolute_times;
  format.first_time = shift;
  format.last_time = shift + (bounds.max - bounds.min) * unit.seconds;
  if (read && is_relative) {
    result.scan.time_span = {format.first_time, format.last_time};
    if (unit.seconds == 1.0) return;
    for (float& time : times) time *= static_cast<float>(unit.seconds);
    return;
  }
  times.resize(result.scan.cloud.size());
  read_times(message, fields, {base, bounds.min, unit.seconds, shift}, times);
}

}  // namespace lidar_mapping::ros_border
