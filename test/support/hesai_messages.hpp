// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include "cloud_forms.hpp"
#include "driver_messages.hpp"
#include "hesai_encoder.hpp"

// Messages of drivers of Hesai, whose packages need not be there.
namespace lidar_mapping::test {

/// PandarScan of hesai_lidar, whose packets have any size, or of pandar_msgs, whose packets have
/// places of 1500 bytes.
enum class PandarDriver { kHesaiLidar, kPandarMsgs };

template <PandarDriver driver>
struct PandarPacketMessage {
  static constexpr bool kHasPlaces = driver == PandarDriver::kPandarMsgs;

  ros::Time stamp;
  std::conditional_t<kHasPlaces, std::array<std::uint8_t, 1500>, std::vector<std::uint8_t>> data{};
  std::uint32_t size = 0;

  PandarPacketMessage() = default;
  PandarPacketMessage(const ros::Time& time, const HesaiBytes& bytes)
      : stamp(time), size(static_cast<std::uint32_t>(bytes.size())) {
    if constexpr (kHasPlaces) {
      std::copy(bytes.begin(), bytes.end(), data.begin());
    } else {
      data = bytes;
    }
  }
};

template <PandarDriver driver>
struct PandarScanMessage {
  std_msgs::Header header;
  std::vector<PandarPacketMessage<driver>> packets;
};

template <PandarDriver driver>
const char* pandar_definition() {
  static const std::string text =
      definition("Header header\nPandarPacket[] packets\n",
                 driver == PandarDriver::kHesaiLidar
                     ? "hesai_lidar/PandarPacket\ntime stamp\nuint8[] data\nuint32 size\n"
                     : "pandar_msgs/PandarPacket\ntime stamp\nuint8[1500] data\nuint32 size\n");
  return text.c_str();
}

/// A turn of a PandarXT-16 as its packets, with the times at which they come, and as the cloud that
/// these stand for.
struct HesaiTurn {
  std::vector<std::pair<ros::Time, HesaiBytes>> packets;
  sensor_msgs::PointCloud2 cloud;

  /// As the drivers have it, hesai_lidar without a stamp.
  template <PandarDriver driver>
  PandarScanMessage<driver> message() const {
    PandarScanMessage<driver> scan;
    scan.header = cloud.header;
    if (driver == PandarDriver::kHesaiLidar) scan.header.stamp = ros::Time();
    for (const auto& [time, bytes] : packets) scan.packets.emplace_back(time, bytes);
    return scan;
  }
};

/// Writes what a simulated VLP-16 (1800 columns of 16 beams, clockwise from behind) has measured as
/// packets of a PandarXT-16, which has the same elevations: ranges in steps of 4 mm, and each beam
/// at the direction that it has in them. The azimuth of a Hesai counts from y on, which is to the
/// left of the simulated sensor.
class HesaiTurnWriter {
 public:
  explicit HesaiTurnWriter(const sensor_msgs::PointCloud2& plain) : plain_(plain) {
    counts_.resize(kColumns * kLasers);
    for (const TimedPoint& point : points_of(plain)) add(point);
  }

  HesaiTurn write() const {
    HesaiTurn turn;
    std::vector<TimedPoint> points;
    for (std::size_t packet = 0; packet < kColumns / kBlocks; ++packet) {
      std::vector<HesaiBlock> blocks;
      for (std::size_t block = 0; block < kBlocks; ++block) {
        const std::size_t column = kBlocks * packet + block;
        blocks.push_back({static_cast<std::uint16_t>((27000 + 20 * column) % 36000),
                          [this, column](std::size_t laser) { return measured(column, laser); }});
        for (std::size_t laser = 0; laser < kLasers; ++laser) add_point(column, laser, points);
      }
      const auto by_sensor = static_cast<std::uint32_t>(950'000 + microseconds(packet));
      turn.packets.emplace_back(
          plain_.header.stamp + ros::Duration(0, 1000 * microseconds(packet)),
          HesaiPacketWriter(kPandarXt16).write(blocks, by_sensor % 1'000'000));
    }
    std_msgs::Header header = plain_.header;
    header.stamp = turn.packets.front().first;
    for (TimedPoint& point : points) {
      point.time -= static_cast<float>((header.stamp - plain_.header.stamp).toSec());
    }
    turn.cloud = plain_cloud(header, points);
    return turn;
  }

 private:
  static constexpr std::size_t kColumns = 1800;
  static constexpr std::size_t kLasers = 16;
  static constexpr std::size_t kBlocks = 8;

  /// When a packet is complete, after the beginning of the turn.
  static std::int32_t microseconds(std::size_t packet) {
    return static_cast<std::int32_t>(
        std::lround(1e5 * static_cast<double>(kBlocks * packet + kBlocks - 1) / kColumns));
  }
  static double elevation_deg(std::size_t laser) { return 15.0 - 2.0 * static_cast<double>(laser); }

  HesaiReturn measured(std::size_t column, std::size_t laser) const {
    return {counts_[kLasers * column + laser], 77};
  }
  void add(const TimedPoint& point) {
    const double range =
        std::sqrt(static_cast<double>(point.x) * point.x + point.y * point.y + point.z * point.z);
    const double elevation = std::asin(point.z / range) * kDegPerRad;
    const double azimuth = 180.0 - std::atan2(point.y, point.x) * kDegPerRad;
    const auto column = static_cast<std::size_t>(std::lround(azimuth * 5.0)) % kColumns;
    for (std::size_t laser = 0; laser < kLasers; ++laser) {
      if (std::abs(elevation_deg(laser) - elevation) > 0.9) continue;
      counts_[kLasers * column + laser] = static_cast<std::uint16_t>(std::lround(range / 0.004));
    }
  }
  void add_point(std::size_t column, std::size_t laser, std::vector<TimedPoint>& points) const {
    const HesaiReturn value = measured(column, laser);
    if (value.counts == 0) return;
    const double firing_us = 0.368 + 3.024 * static_cast<double>(laser);
    const double azimuth = 270.0 + 0.2 * static_cast<double>(column) + 0.2 * firing_us / 50.0;
    const Eigen::Vector3d p = hesai_seen_at(0.004 * value.counts, azimuth, elevation_deg(laser));
    const double before_last = static_cast<double>(kBlocks - 1 - column % kBlocks);
    const double time =
        1e-6 * (microseconds(column / kBlocks) + 5.632 - 50.0 * before_last + firing_us);
    points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                      static_cast<float>(p.z()), 77.0F, static_cast<float>(time)});
  }

  sensor_msgs::PointCloud2 plain_;
  std::vector<std::uint16_t> counts_;
};

}  // namespace lidar_mapping::test

ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(
    lidar_mapping::test::PandarScanMessage<lidar_mapping::test::PandarDriver::kHesaiLidar>,
    "70c3ed4f4ae9144323298b04cc2c760b", "hesai_lidar/PandarScan",
    lidar_mapping::test::pandar_definition<lidar_mapping::test::PandarDriver::kHesaiLidar>())
ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(
    lidar_mapping::test::PandarScanMessage<lidar_mapping::test::PandarDriver::kPandarMsgs>,
    "96facf9d6e028e0cacbe7058fbabc851", "pandar_msgs/PandarScan",
    lidar_mapping::test::pandar_definition<lidar_mapping::test::PandarDriver::kPandarMsgs>())

namespace ros {
namespace message_traits {

template <lidar_mapping::test::PandarDriver driver>
struct IsMessage<lidar_mapping::test::PandarScanMessage<driver>> : TrueType {};
template <lidar_mapping::test::PandarDriver driver>
struct HasHeader<lidar_mapping::test::PandarScanMessage<driver>> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <lidar_mapping::test::PandarDriver driver>
struct Serializer<lidar_mapping::test::PandarPacketMessage<driver>> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.stamp);
    if constexpr (driver == lidar_mapping::test::PandarDriver::kPandarMsgs) {
      for (auto& byte : m.data) stream.next(byte);
    } else {
      stream.next(m.data);
    }
    stream.next(m.size);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <lidar_mapping::test::PandarDriver driver>
struct Serializer<lidar_mapping::test::PandarScanMessage<driver>> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.header);
    stream.next(m.packets);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
