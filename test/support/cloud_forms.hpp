// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>

#include "driver_messages.hpp"
#include "velodyne_encoder.hpp"

// The clouds of simulate_drive (x y z intensity time as floats) in the forms of other drivers.
namespace lidar_mapping::test {

struct TimedPoint {
  float x, y, z, intensity, time;
};

inline std::vector<TimedPoint> points_of(const sensor_msgs::PointCloud2& cloud) {
  std::vector<TimedPoint> points(cloud.width);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::memcpy(&points[i], cloud.data.data() + i * cloud.point_step, sizeof(TimedPoint));
  }
  return points;
}

inline void add_field(sensor_msgs::PointCloud2& cloud, const std::string& name,
                      std::uint8_t datatype, std::uint32_t offset) {
  sensor_msgs::PointField field;
  field.name = name;
  field.datatype = datatype;
  field.offset = offset;
  field.count = 1;
  cloud.fields.push_back(field);
}

/// A cloud of x y z intensity and, if `has_times`, time.
inline sensor_msgs::PointCloud2 plain_cloud(const std_msgs::Header& header,
                                            const std::vector<TimedPoint>& points) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = header;
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z", "intensity", "time"}) {
    add_field(cloud, name, sensor_msgs::PointField::FLOAT32, offset);
    offset += 4;
  }
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(points.size());
  cloud.point_step = offset;
  cloud.row_step = offset * cloud.width;
  cloud.data.resize(cloud.row_step);
  std::memcpy(cloud.data.data(), points.data(), cloud.data.size());
  return cloud;
}

/// Absolute times as seconds and nanoseconds beyond them.
inline sensor_msgs::PointCloud2 with_split_times(const sensor_msgs::PointCloud2& plain) {
  using sensor_msgs::PointField;
  const std::vector<TimedPoint> points = points_of(plain);
  sensor_msgs::PointCloud2 cloud = plain;
  cloud.fields.pop_back();
  add_field(cloud, "time_sec", PointField::UINT32, 16);
  add_field(cloud, "time_nsec", PointField::UINT32, 20);
  cloud.point_step = 24;
  cloud.row_step = 24 * cloud.width;
  cloud.data.resize(cloud.row_step);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto nsec = static_cast<std::int64_t>(plain.header.stamp.toNSec()) +
                      std::llround(1e9 * static_cast<double>(points[i].time));
    const auto sec = static_cast<std::uint32_t>(nsec / 1'000'000'000);
    const auto rest = static_cast<std::uint32_t>(nsec % 1'000'000'000);
    std::uint8_t* at = cloud.data.data() + 24 * i;
    std::memcpy(at, &points[i], 16);
    std::memcpy(at + 16, &sec, 4);
    std::memcpy(at + 20, &rest, 4);
  }
  return cloud;
}

template <LivoxDriver driver>
LivoxMessage<driver> as_livox(const sensor_msgs::PointCloud2& plain) {
  LivoxMessage<driver> message;
  message.header = plain.header;
  message.timebase = plain.header.stamp.toNSec();
  for (const TimedPoint& point : points_of(plain)) {
    const auto offset = static_cast<std::uint32_t>(
        std::llround(1e9 * static_cast<double>(std::max(0.0F, point.time))));
    message.points.push_back(
        {offset, point.x, point.y, point.z, static_cast<std::uint8_t>(point.intensity), 0, 0});
  }
  message.point_num = static_cast<std::uint32_t>(message.points.size());
  return message;
}

inline sensor_msgs::PointCloud as_point_cloud1(const sensor_msgs::PointCloud2& plain) {
  sensor_msgs::PointCloud cloud;
  cloud.header = plain.header;
  cloud.channels.resize(2);
  cloud.channels[0].name = "intensity";
  cloud.channels[1].name = "time";
  for (const TimedPoint& point : points_of(plain)) {
    geometry_msgs::Point32 position;
    position.x = point.x;
    position.y = point.y;
    position.z = point.z;
    cloud.points.push_back(position);
    cloud.channels[0].values.push_back(point.intensity);
    cloud.channels[1].values.push_back(point.time);
  }
  return cloud;
}

/// A turn of a VLP-16 as its packets, and as the cloud that these stand for.
struct VelodyneTurn {
  VelodyneScanMessage packets;
  sensor_msgs::PointCloud2 cloud;
};

/// Writes what a simulated VLP-16 (1800 columns of 16 beams, clockwise from behind) has measured as
/// its packets: ranges in steps of 2 mm, and each beam at the direction that it has in them.
class VelodyneTurnWriter {
 public:
  explicit VelodyneTurnWriter(const sensor_msgs::PointCloud2& plain) : plain_(plain) {
    counts_.resize(kColumns * 16);
    for (const TimedPoint& point : points_of(plain)) add(point);
  }

  VelodyneTurn write() const {
    VelodyneTurn turn;
    turn.packets.header = plain_.header;
    std::vector<TimedPoint> points;
    for (std::size_t packet = 0; packet < kColumns / kColumnsOfPacket; ++packet) {
      VelodynePacketMessage message;
      message.stamp = plain_.header.stamp + ros::Duration(0, 1000 * microseconds(packet));
      for (std::size_t block = 0; block < 12; ++block) {
        const std::size_t column = kColumnsOfPacket * packet + 2 * block;
        put_block(message.data, block, static_cast<std::uint16_t>((18000 + 20 * column) % 36000),
                  [&](std::size_t channel) { return measured(column, channel); });
        for (std::size_t channel = 0; channel < 32; ++channel) add_point(column, channel, points);
      }
      put_end(message.data, 77'000'000U + static_cast<std::uint32_t>(microseconds(packet)),
              kStrongest, kIsVlp16);
      turn.packets.packets.push_back(message);
    }
    // As the driver stamps it.
    turn.packets.header.stamp = turn.packets.packets.back().stamp;
    for (TimedPoint& point : points) {
      point.time -= static_cast<float>((turn.packets.header.stamp - plain_.header.stamp).toSec());
    }
    turn.cloud = plain_cloud(turn.packets.header, points);
    return turn;
  }

 private:
  static constexpr std::size_t kColumns = 1800;
  static constexpr std::size_t kColumnsOfPacket = 24;

  static std::int32_t microseconds(std::size_t packet) {
    return static_cast<std::int32_t>(std::lround(1e5 * static_cast<double>(packet) / 75.0));
  }
  VelodyneReturn measured(std::size_t column, std::size_t channel) const {
    return {counts_[16 * (column + channel / 16) + channel % 16], 77};
  }
  void add(const TimedPoint& point) {
    const double range =
        std::sqrt(static_cast<double>(point.x) * point.x + point.y * point.y + point.z * point.z);
    const double elevation = std::asin(point.z / range) * kDegPerRad;
    const double azimuth = 180.0 - std::atan2(point.y, point.x) * kDegPerRad;
    const auto column = static_cast<std::size_t>(std::lround(azimuth * 5.0)) % kColumns;
    for (std::size_t laser = 0; laser < 16; ++laser) {
      if (std::abs(kVlp16Elevations[laser] - elevation) > 0.9) continue;
      counts_[16 * column + laser] = static_cast<std::uint16_t>(std::lround(range / 0.002));
    }
  }
  void add_point(std::size_t column, std::size_t channel, std::vector<TimedPoint>& points) const {
    const VelodyneReturn value = measured(column, channel);
    if (value.counts == 0) return;
    const double firing_us =
        55.296 * static_cast<double>(channel / 16) + 2.304 * static_cast<double>(channel % 16);
    const double azimuth = 180.0 + 0.2 * static_cast<double>(column) + 0.4 * firing_us / 110.592;
    const Eigen::Vector3d p =
        seen_at(0.002 * value.counts, azimuth, kVlp16Elevations[channel % 16]);
    const double time =
        1e-6 * (microseconds(column / kColumnsOfPacket) +
                110.592 * static_cast<double>(column % kColumnsOfPacket / 2) + firing_us);
    points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                      static_cast<float>(p.z()), 77.0F, static_cast<float>(time)});
  }

  sensor_msgs::PointCloud2 plain_;
  std::vector<std::uint16_t> counts_;
};

}  // namespace lidar_mapping::test
