// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/cloud_reader.hpp"

#include <optional>
#include <string>
#include <utility>

#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "clouds/driver_messages.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// The calibration in a file that is read by `read`; none if the path is empty.
template <typename Calibration>
std::optional<Calibration> calibration_in(const std::string& path,
                                          Calibration (*read)(const std::string& path)) {
  if (path.empty()) return std::nullopt;
  return read(expanded_path(path).string());
}

}  // namespace

CloudReader::CloudReader(const preprocessing::PreprocessingConfig& config)
    : config_(config),
      velodyne_(
          calibration_in(config.velodyne_calibration, preprocessing::read_velodyne_calibration)),
      hesai_(calibration_in(config.hesai_calibration, preprocessing::read_hesai_calibration)) {}

DecodedCloud CloudReader::read(const RecordedCloud& cloud) const {
  DecodedCloud result = read_lazily(cloud);
  result.scan.unpack();
  return result;
}

DecodedCloud CloudReader::read_lazily(const RecordedCloud& cloud, PointCloud buffer) const {
  if (cloud.holds_packets()) return read_packets(cloud, std::move(buffer));
  return decode_lazily(cloud.view(), cloud.memory, config_, std::move(buffer));
}

DecodedCloud CloudReader::read_packets(const RecordedCloud& cloud, PointCloud buffer) const {
  DecodedCloud result;
  const std_msgs::Header& header = cloud.message.header;
  result.scan.stamp = from_ros(header.stamp);
  result.scan.frame_id = frame_name(header.frame_id);
  const Stamp stamp = result.scan.stamp;
  preprocessing::PacketScan scan;
  if (cloud.packets == PacketLayout::kVelodyne) {
    scan = velodyne_.decode(velodyne_packets(cloud.data), stamp, std::move(buffer));
  } else {
    scan = hesai_.decode(hesai_packets(cloud), stamp, std::move(buffer));
  }
  result.scan.cloud = std::move(scan.cloud);
  result.scan.times_are_absolute = true;
  result.scan.time_span = scan.span;
  CloudFormat& format = result.format;
  format.contents = scan.contents;
  format.damaged_packets = scan.damaged_packets;
  format.intensity_field = "reflectivity";
  if (result.scan.cloud.empty()) return result;
  format.time_field = "packets";
  format.time_unit = "us";
  format.absolute_times = true;
  format.first_time = scan.span.begin;
  format.last_time = scan.span.end;
  return result;
}

}  // namespace lidar_mapping::ros_border
