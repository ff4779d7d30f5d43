#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

using preprocessing::PointTimeUnit;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

const std::array<const char*, 3> kIntensityNames = {"intensity", "i", "reflectivity"};
const std::array<const char*, 6> kTimeNames = {"time",       "t",           "timestamp",
                                               "time_stamp", "offset_time", "time_offset"};

/// A scan whose times span less or more of its period than this has them in another unit.
constexpr double kShortestShare = 0.1;
constexpr double kLongestShare = 2.5;
/// Absolute times lie this near to the stamp.
constexpr double kSeam = 0.006;     // of a scan's time at each of its ends
constexpr double kSameClock = 2.0;  // s

struct Unit {
  const char* name;
  double seconds;
};
constexpr std::array<Unit, 4> kUnits = {{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};

std::size_t size_of(std::uint8_t datatype) {
  switch (datatype) {
    case PointField::INT8:
    case PointField::UINT8:
      return 1;
    case PointField::INT16:
    case PointField::UINT16:
      return 2;
    case PointField::INT32:
    case PointField::UINT32:
    case PointField::FLOAT32:
      return 4;
    case PointField::FLOAT64:
      return 8;
    default:
      return 0;
  }
}

void check_field(const PointCloud2& message, const PointField& field) {
  const std::size_t size = size_of(field.datatype);
  if (size == 0) {
    throw InputError("cloud: field '" + field.name + "' has the unknown datatype " +
                     std::to_string(field.datatype));
  }
  if (field.offset > message.point_step || size > message.point_step - field.offset) {
    throw InputError("cloud: field '" + field.name + "' lies outside of the point of " +
                     std::to_string(message.point_step) + " bytes");
  }
}

const PointField* find(const PointCloud2& message, const std::string& name) {
  for (const PointField& field : message.fields) {
    if (field.name != name) continue;
    check_field(message, field);
    return &field;
  }
  return nullptr;
}

template <std::size_t count>
const PointField* find_any(const PointCloud2& message,
                           const std::array<const char*, count>& names) {
  for (const char* name : names) {
    if (const PointField* field = find(message, name)) return field;
  }
  return nullptr;
}

const PointField& coordinate(const PointCloud2& message, const std::string& name) {
  const PointField* field = find(message, name);
  if (field == nullptr) {
    throw InputError("cloud: no field '" + name + "'; the driver must publish x, y and z");
  }
  if (field->datatype != PointField::FLOAT32 && field->datatype != PointField::FLOAT64) {
    throw InputError("cloud: field '" + name + "' is no FLOAT32 or FLOAT64");
  }
  return *field;
}

/// Sizes are compared by division, so that no product of theirs overflows.
void check_size(const PointCloud2& message) {
  if (message.is_bigendian) {
    throw InputError("cloud: big-endian data; the driver must publish little-endian ones");
  }
  const std::size_t bytes = message.data.size();
  const bool fits = message.point_step > 0 && message.width <= bytes / message.point_step;
  const std::size_t row = fits ? std::size_t{message.width} * message.point_step : 0;
  const bool rows_fit =
      message.height <= 1 || (message.row_step >= row && message.row_step > 0 &&
                              message.height - 1 <= (bytes - row) / message.row_step);
  if (fits && rows_fit) return;
  throw InputError("cloud: " + std::to_string(bytes) + " bytes of data are fewer than " +
                   std::to_string(message.height) + " x " + std::to_string(message.width) +
                   " points need; the message was cut off");
}

/// Calls body(address, index) for every point.
template <typename Body>
void for_each_point(const PointCloud2& message, const Body& body) {
  std::size_t index = 0;
  for (std::size_t row = 0; row < message.height; ++row) {
    const std::uint8_t* in = message.data.data() + row * message.row_step;
    for (std::size_t column = 0; column < message.width; ++column, in += message.point_step) {
      body(in, index++);
    }
  }
}

template <typename Number>
Number read(const std::uint8_t* address) {
  Number value;
  std::memcpy(&value, address, sizeof value);
  return value;
}

/// Calls body(read) with the function that reads numbers of this type.
template <typename Body>
void with_reader(std::uint8_t datatype, const Body& body) {
  switch (datatype) {
    case PointField::INT8:
      return body(&read<std::int8_t>);
    case PointField::UINT8:
      return body(&read<std::uint8_t>);
    case PointField::INT16:
      return body(&read<std::int16_t>);
    case PointField::UINT16:
      return body(&read<std::uint16_t>);
    case PointField::INT32:
      return body(&read<std::int32_t>);
    case PointField::UINT32:
      return body(&read<std::uint32_t>);
    case PointField::FLOAT32:
      return body([](const std::uint8_t* address) { return read<float>(address); });
    default:
      return body(&read<double>);
  }
}

/// The layout of nearly all drivers, for which a point is two copies.
bool is_packed(const PointField& x, const PointField& y, const PointField& z) {
  return x.datatype == PointField::FLOAT32 && y.datatype == PointField::FLOAT32 &&
         z.datatype == PointField::FLOAT32 && y.offset == x.offset + 4 && z.offset == x.offset + 8;
}

bool is_contiguous(const PointCloud2& message) {
  return message.height == 1 || message.row_step == std::size_t{message.width} * message.point_step;
}

/// Values at equal distances in memory. Ranges of it fill a vector without clearing it first.
template <typename Value, typename Read>
class Strided {
 public:
  using iterator_category = std::random_access_iterator_tag;
  using value_type = Value;
  using difference_type = std::ptrdiff_t;
  using pointer = const Value*;
  using reference = Value;

  Strided(const std::uint8_t* address, std::size_t step, Read read_value)
      : address_(address), step_(step), read_(read_value) {}
  Value operator*() const { return read_(address_); }
  Strided& operator++() {
    address_ += step_;
    return *this;
  }
  Strided& operator--() {
    address_ -= step_;
    return *this;
  }
  Strided& operator+=(difference_type count) {
    address_ += count * static_cast<difference_type>(step_);
    return *this;
  }
  Strided operator+(difference_type count) const { return Strided(*this) += count; }
  difference_type operator-(const Strided& other) const {
    return (address_ - other.address_) / static_cast<difference_type>(step_);
  }
  bool operator==(const Strided& other) const { return address_ == other.address_; }
  bool operator!=(const Strided& other) const { return address_ != other.address_; }

 private:
  const std::uint8_t* address_;
  std::size_t step_;
  Read read_;
};

template <typename Value, typename Read>
void fill(const PointCloud2& message, const Read& read_value, std::vector<Value>& values) {
  const Strided<Value, Read> begin(message.data.data(), message.point_step, read_value);
  const auto count = static_cast<std::ptrdiff_t>(std::size_t{message.width} * message.height);
  values.assign(begin, begin + count);
}

/// All of a cloud whose intensity is a float as well; false for other layouts.
bool read_packed(const PointCloud2& message, const PointField* intensity,
                 std::vector<Point>& points) {
  const PointField& x = coordinate(message, "x");
  if (!is_contiguous(message) ||
      !is_packed(x, coordinate(message, "y"), coordinate(message, "z")) || intensity == nullptr ||
      intensity->datatype != PointField::FLOAT32) {
    return false;
  }
  const std::size_t at_x = x.offset;
  const std::size_t at_intensity = intensity->offset;
  fill(
      message,
      [at_x, at_intensity](const std::uint8_t* in) {
        std::array<float, 4> values;
        std::memcpy(values.data(), in + at_x, 12);
        std::memcpy(&values[3], in + at_intensity, 4);
        return Point{values[0], values[1], values[2], values[3]};
      },
      points);
  return true;
}

void read_coordinates(const PointCloud2& message, std::vector<Point>& points) {
  const PointField& x = coordinate(message, "x");
  const PointField& y = coordinate(message, "y");
  const PointField& z = coordinate(message, "z");
  if (is_packed(x, y, z)) {
    for_each_point(message, [&](const std::uint8_t* in, std::size_t i) {
      std::array<float, 3> position;
      std::memcpy(position.data(), in + x.offset, sizeof position);
      points[i] = {position[0], position[1], position[2], 0.0F};
    });
    return;
  }
  const auto read_axis = [&](const PointField& field, float Point::*axis) {
    with_reader(field.datatype, [&](const auto& number) {
      for_each_point(message, [&](const std::uint8_t* in, std::size_t i) {
        points[i].*axis = static_cast<float>(number(in + field.offset));
      });
    });
  };
  read_axis(x, &Point::x);
  read_axis(y, &Point::y);
  read_axis(z, &Point::z);
}

void read_intensity(const PointCloud2& message, const PointField& field,
                    std::vector<Point>& points) {
  with_reader(field.datatype, [&](const auto& number) {
    for_each_point(message, [&](const std::uint8_t* in, std::size_t i) {
      points[i].intensity = static_cast<float>(number(in + field.offset));
    });
  });
}

/// Smallest and largest finite value of a field, as it is written.
struct Bounds {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
};

Bounds bounds_of(const PointCloud2& message, const PointField& field) {
  Bounds bounds;
  with_reader(field.datatype, [&](const auto& number) {
    for_each_point(message, [&](const std::uint8_t* in, std::size_t) {
      const auto value = static_cast<double>(number(in + field.offset));
      if (!std::isfinite(value)) return;
      bounds.min = value < bounds.min ? value : bounds.min;
      bounds.max = value > bounds.max ? value : bounds.max;
    });
  });
  return bounds;
}

Bounds bounds_of(const PointCloud& cloud) {
  const preprocessing::TimeSpan span = preprocessing::time_span(cloud);
  return {span.begin, span.end};
}

std::optional<Unit> configured_unit(PointTimeUnit unit) {
  if (unit == PointTimeUnit::kAuto) return std::nullopt;
  return kUnits[static_cast<std::size_t>(unit) - 1];
}

/// The unit in which the times span about a turn; where none does, the usual one of the type.
Unit unit_of(const PointField& field, const Bounds& bounds,
             const preprocessing::PreprocessingConfig& config) {
  if (const auto unit = configured_unit(config.point_time_unit)) return *unit;
  for (const Unit& unit : kUnits) {
    const double share = (bounds.max - bounds.min) * unit.seconds / config.scan_period;
    if (share > kShortestShare && share < kLongestShare) return unit;
  }
  const bool counts = size_of(field.datatype) == 4 && field.datatype != PointField::FLOAT32;
  return counts ? kUnits[3] : kUnits[0];
}

/// Differences from a time near to them, so that absolute nanoseconds keep their digits.
void read_times(const PointCloud2& message, const PointField& field, double origin, double unit,
                double shift, std::vector<float>& times) {
  with_reader(field.datatype, [&](const auto& number) {
    for_each_point(message, [&](const std::uint8_t* in, std::size_t i) {
      const double since_origin = static_cast<double>(number(in + field.offset)) - origin;
      times[i] = static_cast<float>(since_origin * unit + shift);
    });
  });
}

/// Times of four bytes as floats, as they are written: 8 ns of 0.1 s is what that costs. False for
/// other layouts.
bool read_raw_times(const PointCloud2& message, const PointField& field,
                    std::vector<float>& times) {
  const std::size_t offset = field.offset;
  if (!is_contiguous(message)) return false;
  if (field.datatype == PointField::FLOAT32) {
    fill(
        message, [offset](const std::uint8_t* in) { return read<float>(in + offset); }, times);
    return true;
  }
  if (field.datatype == PointField::UINT32) {
    fill(
        message,
        [offset](const std::uint8_t* in) {
          return static_cast<float>(read<std::uint32_t>(in + offset));
        },
        times);
    return true;
  }
  return false;
}

/// `origin` (in the field's unit) minus the stamp, s. Whole seconds are subtracted first.
double since_stamp(double origin, double unit, const ros::Time& stamp) {
  const double per_second = std::round(1.0 / unit);
  const double whole = std::floor(origin / per_second);
  const double rest = (origin - whole * per_second) * unit;
  return (whole - static_cast<double>(stamp.sec)) + (rest - 1e-9 * stamp.nsec);
}

void decode_times(const PointCloud2& message, const PointField& field,
                  const preprocessing::PreprocessingConfig& config, DecodedCloud& result) {
  std::vector<float>& times = result.scan.cloud.times;
  const bool is_read = read_raw_times(message, field, times);
  const Bounds bounds = is_read ? bounds_of(result.scan.cloud) : bounds_of(message, field);
  if (!(bounds.max > bounds.min)) {  // a field that nobody fills
    times.clear();
    return;
  }
  const Unit unit = unit_of(field, bounds, config);
  const double longest = kLongestShare * config.scan_period;
  const double first = bounds.min * unit.seconds;
  const double from_stamp = since_stamp(bounds.min, unit.seconds, message.header.stamp);
  CloudFormat& format = result.format;
  format.time_field = field.name;
  format.time_unit = unit.name;
  const bool is_relative = std::abs(first) < longest;
  format.absolute_times = !is_relative && std::abs(from_stamp) < kSameClock;
  format.foreign_clock = !is_relative && !format.absolute_times;
  const double shift = is_relative ? first : format.absolute_times ? from_stamp : 0.0;
  result.scan.times_are_absolute = format.absolute_times;
  format.first_time = shift;
  format.last_time = shift + (bounds.max - bounds.min) * unit.seconds;
  if (is_read && is_relative) {
    if (unit.seconds == 1.0) return;
    for (float& time : times) time *= static_cast<float>(unit.seconds);
    return;
  }
  times.resize(result.scan.cloud.size());
  read_times(message, field, bounds.min, unit.seconds, shift, times);
}

std::string names_of(const PointCloud2& message) {
  std::string names;
  for (const PointField& field : message.fields) names += (names.empty() ? "" : " ") + field.name;
  return names;
}

/// The points that were measured first and last.
void add_seam(const PointCloud& cloud, preprocessing::CloudSummary& summary) {
  if (!cloud.has_times()) return;
  const preprocessing::TimeSpan span = preprocessing::time_span(cloud);
  const double width = kSeam * (span.end - span.begin);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool begins = cloud.times[i] <= span.begin + width;
    const bool ends = cloud.times[i] >= span.end - width;
    if (!begins && !ends) continue;
    const Eigen::Vector3f p = cloud.points[i].position();
    if (p.allFinite()) (begins ? summary.begin_points : summary.end_points).push_back(p);
  }
}

}  // namespace

DecodedCloud decode(const PointCloud2& message, const preprocessing::PreprocessingConfig& config,
                    PointCloud buffer) {
  DecodedCloud result;
  result.scan.cloud = std::move(buffer);
  result.scan.cloud.points.clear();
  result.scan.cloud.times.clear();
  result.scan.stamp = from_ros(message.header.stamp);
  result.scan.frame_id = frame_name(message.header.frame_id);
  result.format.fields = names_of(message);
  if (message.width == 0 || message.height == 0) return result;
  check_size(message);
  const PointField* intensity = find_any(message, kIntensityNames);
  if (intensity != nullptr) result.format.intensity_field = intensity->name;
  std::vector<Point>& points = result.scan.cloud.points;
  if (!read_packed(message, intensity, points)) {
    points.resize(std::size_t{message.width} * message.height);
    read_coordinates(message, points);
    if (intensity != nullptr) read_intensity(message, *intensity, points);
  }
  if (config.point_times == preprocessing::PointTimes::kNone) return result;
  if (const PointField* time = find_any(message, kTimeNames)) {
    decode_times(message, *time, config, result);
  }
  return result;
}

preprocessing::CloudSummary summary_of(const PointCloud2& message, const DecodedCloud& decoded) {
  preprocessing::CloudSummary summary;
  summary.stamp = decoded.scan.stamp;
  summary.frame_id = message.header.frame_id;
  summary.points = decoded.scan.cloud.size();
  summary.fields = decoded.format.fields;
  summary.time_field = decoded.format.time_field;
  summary.time_unit = decoded.format.time_unit;
  summary.absolute_times = decoded.format.absolute_times;
  summary.foreign_clock = decoded.format.foreign_clock;
  summary.first_time = decoded.format.first_time;
  summary.last_time = decoded.format.last_time;
  add_seam(decoded.scan.cloud, summary);
  return summary;
}

}  // namespace lidar_mapping::ros_border
