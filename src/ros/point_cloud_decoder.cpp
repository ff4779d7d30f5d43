#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "point_fields.hpp"
#include "point_times.hpp"

namespace lidar_mapping::ros_border {

namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

const std::array<const char*, 3> kIntensityNames = {"intensity", "i", "reflectivity"};

constexpr double kSeam = 0.006;  // of a scan's time at each of its ends

/// The layout of nearly all drivers, for which a point is two copies.
bool is_packed(const PointField& x, const PointField& y, const PointField& z) {
  return x.datatype == PointField::FLOAT32 && y.datatype == PointField::FLOAT32 &&
         z.datatype == PointField::FLOAT32 && y.offset == x.offset + 4 && z.offset == x.offset + 8;
}

/// Places of the fields in a point.
struct Offsets {
  std::size_t x, intensity, time;
};

/// Points whose coordinates lie side by side, a float intensity, and times of four bytes as they
/// are written (as a float a time costs 8 ns of 0.1 s).
template <typename Time>
void read_points(const std::uint8_t* in, std::size_t step, const Offsets& at, std::size_t count,
                 Point* points, float* times) {
  for (std::size_t i = 0; i < count; ++i, in += step) {
    std::memcpy(&points[i], in + at.x, sizeof(Point));  // one load and store of a whole register
    points[i].intensity = read<float>(in + at.intensity);
    if constexpr (!std::is_void_v<Time>) times[i] = static_cast<float>(read<Time>(in + at.time));
  }
}

/// By blocks that are still in the cache when their times are looked at.
template <typename Time>
preprocessing::TimeSpan read_blocks(const PointCloud2& message, const Offsets& at,
                                    PointCloud& cloud) {
  constexpr std::size_t kBlock = 512;
  preprocessing::TimeSpanFinder finder;
  for (std::size_t begin = 0; begin < cloud.size(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, cloud.size() - begin);
    const std::uint8_t* in = message.data.data() + begin * message.point_step;
    float* const times = cloud.times.data() + begin;
    read_points<Time>(in, message.point_step, at, count, &cloud.points[begin], times);
    finder.add(times, count);
  }
  return finder.span();
}

/// Which of the fields have been read.
struct FastRead {
  bool points = false;
  std::optional<preprocessing::TimeSpan> times;  ///< as they are written
};

/// The layout of nearly all drivers; nothing is read of others. What a buffer holds is overwritten
/// without being cleared first.
FastRead read_packed(const PointCloud2& message, const PointField* intensity,
                     const PointField* time, PointCloud& cloud) {
  const PointField& x = coordinate_field(message, "x");
  if (!is_contiguous(message) ||
      !is_packed(x, coordinate_field(message, "y"), coordinate_field(message, "z")) ||
      intensity == nullptr || intensity->datatype != PointField::FLOAT32 ||
      message.point_step - x.offset < sizeof(Point)) {
    return {};
  }
  const std::size_t count = std::size_t{message.width} * message.height;
  cloud.points.resize(count);
  const Offsets at{x.offset, intensity->offset, time == nullptr ? 0 : time->offset};
  const std::uint8_t type = time == nullptr ? std::uint8_t{0} : time->datatype;
  if (type != PointField::FLOAT32 && type != PointField::UINT32) {
    read_points<void>(message.data.data(), message.point_step, at, count, cloud.points.data(),
                      nullptr);
    return {true, std::nullopt};
  }
  cloud.times.resize(count);
  return {true, type == PointField::FLOAT32 ? read_blocks<float>(message, at, cloud)
                                            : read_blocks<std::uint32_t>(message, at, cloud)};
}

void read_coordinates(const PointCloud2& message, std::vector<Point>& points) {
  const PointField& x = coordinate_field(message, "x");
  const PointField& y = coordinate_field(message, "y");
  const PointField& z = coordinate_field(message, "z");
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
  PointCloud& cloud = result.scan.cloud;
  result.scan.stamp = from_ros(message.header.stamp);
  result.scan.frame_id = frame_name(message.header.frame_id);
  result.format.fields = field_names(message);
  if (message.width == 0 || message.height == 0) return result;
  check_size(message);
  cloud = std::move(buffer);
  const PointField* intensity = find_any_field(message, kIntensityNames);
  if (intensity != nullptr) result.format.intensity_field = intensity->name;
  const bool wants_times = config.point_times != preprocessing::PointTimes::kNone;
  const PointField* time = wants_times ? time_field(message) : nullptr;
  const FastRead fast = read_packed(message, intensity, time, cloud);
  if (!fast.points) {
    cloud.points.assign(std::size_t{message.width} * message.height, Point{});
    read_coordinates(message, cloud.points);
    if (intensity != nullptr) read_intensity(message, *intensity, cloud.points);
  }
  if (!fast.times) cloud.times.clear();
  if (time != nullptr) decode_times(message, *time, config, fast.times, result);
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
