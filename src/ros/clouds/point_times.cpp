// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/point_times.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "lidar_mapping/common/text.hpp"
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

/// A clock that began anew during the scan. Counts below the half of a round are one round later.
struct Round {
  double half = -std::numeric_limits<double>::infinity();
  double length = 0.0;  ///< in the unit of the field

  double unrolled(double count) const { return count < half ? count + length : count; }
};

/// Bounds of the times as if the clock had gone on.
Bounds bounds_of(const CloudView& message, const TimeFields& fields, double base,
                 const Round& round = {}) {
  Bounds bounds;
  for_each_time(message, fields, base, [&](double value, std::size_t) {
    if (!std::isfinite(value)) return;
    bounds.min = std::min(bounds.min, round.unrolled(value));
    bounds.max = std::max(bounds.max, round.unrolled(value));
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

/// How the counts of a scan are to be read.
struct ScanCounts {
  Round round;  ///< of a clock that began anew
  Unit unit;
  Bounds bounds;  ///< unrolled
};

/// The round of a clock whose times reach from its beginning to its end.
std::optional<ScanCounts> broken_scan(const CloudView& message, const TimeFields& fields,
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
      const Bounds unrolled = bounds_of(message, fields, 0.0, round);
      if (is_span_of_scan((unrolled.max - unrolled.min) * unit.seconds, config.scan_period)) {
        return ScanCounts{round, unit, unrolled};
      }
    }
  }
  return std::nullopt;
}

/// The unit that the name of the field is or ends with, as in "usec", "time_us" and "offset_nsec".
std::optional<Unit> named_unit(const TimeFields& fields) {
  const std::string name = lower_case(fields.first->name);
  const std::string end = name.substr(name.rfind('_') + 1);  // all of it without a '_'
  for (const Unit& unit : kUnits) {
    if (end == unit.name || end == unit.name + std::string("ec")) return unit;
  }
  return std::nullopt;
}

/// The unit that the name says, otherwise the usual one of the type.
Unit usual_unit(const TimeFields& fields) {
  if (const auto unit = named_unit(fields)) return *unit;
  const std::uint8_t type = fields.first->datatype;
  const bool counts =
      size_of(type) >= 4 && type != PointField::FLOAT32 && type != PointField::FLOAT64;
  return counts ? kUnits[3] : kUnits[0];
}

/// The unit that fits a scan, if need be one whose clock began anew; otherwise the usual one.
ScanCounts counts_of(const CloudView& message, const TimeFields& fields, const Bounds& bounds,
                     const preprocessing::PreprocessingConfig& config) {
  if (const auto unit = fitting_unit(fields, bounds, config)) return {{}, *unit, bounds};
  if (const auto broken = broken_scan(message, fields, config)) return *broken;
  return {{}, usual_unit(fields), bounds};
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

/// What the times of a scan count from.
enum class TimeOrigin {
  kStamp,         ///< its own stamp
  kClock,         ///< the epoch of the clock of the stamps
  kForeignClock,  ///< that of another clock: the first point counts as being at the stamp
};

/// The earliest time of a scan.
struct FirstTime {
  TimeOrigin origin;
  double seconds;  ///< after the stamp
};

/// Times of about a scan's length count from its stamp, greater ones from elsewhere.
FirstTime first_time(double base, const ScanCounts& counts, const ros::Time& stamp,
                     const preprocessing::PreprocessingConfig& config) {
  const double first = (base + counts.bounds.min) * counts.unit.seconds;
  if (std::abs(first) < kMaxSpanRatio * config.scan_period) return {TimeOrigin::kStamp, first};
  const double from_stamp = since_stamp(base, counts.bounds.min, counts.unit.seconds, stamp);
  if (std::abs(from_stamp) < kSameClock) return {TimeOrigin::kClock, from_stamp};
  return {TimeOrigin::kForeignClock, 0.0};
}

void describe_times(const TimeFields& fields, const ScanCounts& counts, const FirstTime& first,
                    CloudFormat& format) {
  format.time_field = fields.name();
  format.time_unit = counts.unit.name;
  format.absolute_times = first.origin == TimeOrigin::kClock;
  format.foreign_clock = first.origin == TimeOrigin::kForeignClock;
  format.first_time = first.seconds;
  format.last_time = first.seconds + (counts.bounds.max - counts.bounds.min) * counts.unit.seconds;
}

/// Times that were read as counts from the stamp become seconds.
void scale_times(const Unit& unit, std::vector<float>& times) {
  if (unit.seconds == 1.0) return;
  for (float& time : times) time *= static_cast<float>(unit.seconds);
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
  const ScanCounts counts = counts_of(message, fields, bounds, config);
  const FirstTime first = first_time(base, counts, message.header.stamp, config);
  describe_times(fields, counts, first, result.format);
  result.scan.times_are_absolute = result.format.absolute_times;
  if (read && first.origin == TimeOrigin::kStamp) {
    result.scan.time_span = {result.format.first_time, result.format.last_time};
    return scale_times(counts.unit, times);
  }
  times.resize(result.scan.cloud.size());
  read_times(message, fields,
             {base, counts.bounds.min, counts.unit.seconds, first.seconds, counts.round}, times);
}

}  // namespace lidar_mapping::ros_border
