// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include <array>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "clouds/point_fields.hpp"
#include "clouds/point_times.hpp"

namespace lidar_mapping::ros_border {

namespace {

using sensor_msgs::PointField;

constexpr double kSeam = 0.006;  // of a scan's time at each end; chosen: some columns (2 degrees)

/// The layout of nearly all drivers, for which a point is two copies.
bool is_packed(const PointField& x, const PointField& y, const PointField& z) {
  return x.datatype == PointField::FLOAT32 && y.datatype == PointField::FLOAT32 &&
         z.datatype == PointField::FLOAT32 && y.offset == x.offset + 4 && z.offset == x.offset + 8;
}

/// Where the points of such a layout with a float intensity lie.
std::optional<preprocessing::PackedPoints> packed_points(const CloudView& message,
                                                         const PointField* intensity) {
  const PointField& x = coordinate_field(message, "x");
  if (!is_contiguous(message) ||
      !is_packed(x, coordinate_field(message, "y"), coordinate_field(message, "z")) ||
      intensity == nullptr || intensity->datatype != PointField::FLOAT32 ||
      intensity->offset < x.offset || message.point_step - x.offset < sizeof(Point)) {
    return std::nullopt;
  }
  return preprocessing::PackedPoints{nullptr, message.first + x.offset, message.point_step,
                                     intensity->offset - x.offset};
}

/// Counts as floats (which costs 8 ns of 0.1 s).
preprocessing::TimeSpan read_counts(const CloudView& message, const PointField& field,
                                    std::size_t count, std::vector<float>& times) {
  preprocessing::TimeSpanFinder finder;
  const std::uint8_t* in = message.first + field.offset;
  preprocessing::fill_by_blocks(count, times, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i, in += message.point_step) {
      times[i] = static_cast<float>(number_at<std::uint32_t>(in));
    }
    finder.add(&times[begin], end - begin);
  });
  return finder.span();
}

/// The usual times of four bytes, and their span; nothing is read of others.
std::optional<preprocessing::TimeSpan> read_usual_times(const CloudView& message,
                                                        const PointField* field,
                                                        std::vector<float>& times) {
  const std::uint8_t type = field == nullptr ? std::uint8_t{0} : field->datatype;
  if (!is_contiguous(message) || (type != PointField::FLOAT32 && type != PointField::UINT32)) {
    times.clear();
    return std::nullopt;
  }
  const std::size_t count = std::size_t{message.width} * message.height;
  if (type == PointField::UINT32) return read_counts(message, *field, count, times);
  return preprocessing::read_times(message.first + field->offset, message.point_step, count, times);
}

void read_coordinates(const CloudView& message, std::vector<Point>& points) {
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

void read_intensity(const CloudView& message, const PointField& field, std::vector<Point>& points) {
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

DecodedCloud decode(const CloudView& message, const preprocessing::PreprocessingConfig& config) {
  DecodedCloud result = decode_lazily(message, nullptr, config);
  result.scan.unpack();
  return result;
}

DecodedCloud decode_lazily(const CloudView& message, std::shared_ptr<const void> memory,
                           const preprocessing::PreprocessingConfig& config, PointCloud buffer) {
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
  result.scan.packed = packed_points(message, intensity);
  if (result.scan.packed) {
    result.scan.packed->memory = std::move(memory);
    cloud.points.resize(std::size_t{message.width} * message.height);
  } else {
    cloud.points.assign(std::size_t{message.width} * message.height, Point{});
    read_coordinates(message, cloud.points);
    if (intensity != nullptr) read_intensity(message, *intensity, cloud.points);
  }
  const bool wants_times = config.point_times != preprocessing::PointTimes::kNone;
  const auto times = wants_times ? time_fields(message) : std::nullopt;
  const bool is_single = times && times->second == nullptr;
  const auto span = read_usual_times(message, is_single ? times->first : nullptr, cloud.times);
  if (times) decode_times(message, *times, config, span, result);
  return result;
}

preprocessing::CloudSummary summary_of(const CloudView& message, const DecodedCloud& decoded) {
  preprocessing::CloudSummary summary;
  summary.stamp = decoded.scan.stamp;
  summary.frame_id = message.header.frame_id;
  summary.points = decoded.scan.cloud.size();
  static_cast<CloudFormat&>(summary) = decoded.format;
  summary.extent = preprocessing::extent_of(decoded.scan.cloud);
  add_seam(decoded.scan.cloud, summary);
  return summary;
}

}  // namespace lidar_mapping::ros_border
