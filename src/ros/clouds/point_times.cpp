// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/point_times.hpp"

#include <algorithm>
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
/// s after which clocks begin anew: a second, a minute, an hour, a day; 0 for a count of 32 bits.
/// By definition.
constexpr std::array<double, 5> kRounds = {1.0, 60.0, 3600.0, 86400.0, 0.0};
constexpr double kCountsOfWord = 4294967296.0;  // of 32 bits, by definition: 2^32
/// Of a scan's period, between the times beside the new beginning and it. Chosen: two packets of a
/// sensor with a packet missing between them.
constexpr double kSeamOfRound = 0.1;

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

/// True if a scan lasts about as long, in s.
bool is_span_of_scan(double span, double period) {
  return span > kMinSpanRatio * period && span < kMaxSpanRatio * period;
}

/// The unit in which the times span about one turn of the LiDAR.
std::optional<Unit> fitting_unit(const TimeFields& fields, const Bounds& bounds,
                                 const preprocessing::PreprocessingConfig& config) {
  if (fields.is_in_seconds) return kUnits[0];
  if (const auto unit = configured_unit(config.point_time_unit)) return *unit;
  for (const Unit& unit : kUnits) {
    if (is_span_of_scan((bounds.max - bounds.min) * unit.seconds, config.scan_period)) return unit;
  }
  return std::nullopt;
}

/// A clock that began anew during the scan. Counts below the half of a round are one round later.
struct Round {
  double half = -std::numeric_limits<double>::infinity();
  double length = 0.0;  ///< in the unit of the field

  double unrolled(double count) const { return count < half ? count + length : count; }
};

/// Bounds of the times as if the clock had gone on.
Bounds unrolled_bounds(const CloudView& message, const TimeFields& fields, const Round& round) {
  Bounds bounds;
  for_each_time(message, fields, 0.0, [&](double value, std::size_t) {
    if (!std::isfinite(value)) return;
    bounds.min = std::min(bounds.min, round.unrolled(value));
    bounds.max = std::max(bounds.max, round.unrolled(value));
  });
  return bounds;
}

struct BrokenScan {
  Round round;
  Unit unit;
  Bounds bounds;  ///< unrolled
};

/// The round of a clock whose times reach from its beginning to its end.
std::optional<BrokenScan> broken_scan(const CloudView& message, const TimeFields& fields,
                                      const preprocessing::PreprocessingConfig& config) {
  if (fields.second != nullptr) return std::nullopt;
  const Bounds bounds = bounds_of(message, fields, 0.0);
  for (const Unit& unit : kUnits) {
    const double near = kSeamOfRound * config.scan_period / unit.seconds;
    for (const double seconds : kRounds) {
      const double length = seconds > 0.0 ? seconds / unit.seconds : kCountsOfWord;
      const bool reaches_both = bounds.min >= 0.0 && bounds.min < near && bounds.max < length &&
                                bounds.max > length - near;
      if (!reaches_both) continue;
      const Round round{0.5 * length, length};
      const Bounds unrolled = unrolled_bounds(message, fields, round);
      if (is_span_of_scan((unrolled.max - unrolled.min) * unit.seconds, config.scan_period)) {
        return BrokenScan{round, unit, unrolled};
      }
    }
  }
  return std::nullopt;
}

/// The usual unit of the type.
Unit usual_unit(const TimeFields& fields) {
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
  Round round;    ///< of a clock that began anew
};

/// Differences from a time near to them, so that absolute nanoseconds keep their digits.
void read_times(const CloudView& message, const TimeFields& fields, const TimeScale& scale,
                std::vector<float>& times) {
  for_each_time(message, fields, scale.base, [&](double value, std::size_t i) {
    times[i] =
        static_cast<float>((scale.round.unrolled(value) - scale.origin) * scale.unit + scale.shift);
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
  Bounds bounds = read ? Bounds{read->begin, read->end} : bounds_of(message, fields, base);
  if (!(bounds.max > bounds.min)) {  // the driver does not fill the fields
    times.clear();
    return;
  }
  std::optional<Unit> fitting = fitting_unit(fields, bounds, config);
  Round round;
  if (!fitting) {
    if (const auto broken = broken_scan(message, fields, config)) {
      round = broken->round;
      fitting = broken->unit;
      bounds = broken->bounds;
    }
  }
  const Unit unit = fitting.value_or(usual_unit(fields));
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
  read_times(message, fields, {base, bounds.min, unit.seconds, shift, round}, times);
}

}  // namespace lidar_mapping::ros_border
