// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <std_msgs/String.h>

#include "cloud_forms.hpp"
#include "ouster_encoder.hpp"
#include "ouster_packet_message.hpp"
#include "ros2_writer.hpp"

// Messages of the driver of Ouster, whose package need not be there.
namespace lidar_mapping::test {

inline void write(CdrWriter& out, const OusterPacketMessage& m) {
  out.number(static_cast<std::uint32_t>(m.buf.size()));
  out.array(m.buf);
}

inline void write(CdrWriter& out, const std_msgs::String& m) { out.text(m.data); }

/// A turn as packets, with the times of their last columns, and as the cloud that these stand for.
struct OusterSweep {
  std::vector<std::pair<ros::Time, OusterPacketMessage>> packets;
  sensor_msgs::PointCloud2 cloud;
};

/// Writes what a simulated VLP-16 (1800 columns of 16 beams, clockwise from behind) has measured as
/// packets of an Ouster that looks backwards and has the same elevations: each beam at the
/// direction that it has in them.
class OusterSweepWriter {
 public:
  OusterSweepWriter(const sensor_msgs::PointCloud2& plain, const std::string& profile)
      : plain_(plain) {
    sensor_.profile = profile;
    sensor_.altitudes_deg.assign(kVlp16Elevations.begin(), kVlp16Elevations.end());
    for (std::size_t pixel = 0; pixel < 16; ++pixel) {
      sensor_.azimuths_deg.push_back(0.8 * (static_cast<double>(pixel % 4) - 1.5));
    }
    measured_.resize(sensor_.columns * 16);
    for (const TimedPoint& point : points_of(plain)) add(point);
  }

  const OusterSensor& sensor() const { return sensor_; }

  /// `clock`: how much the sensor's clock is ahead, ns.
  OusterSweep write(std::uint16_t frame, std::int64_t clock) const {
    const std::uint64_t begin = plain_.header.stamp.toNSec();
    const std::uint64_t by_sensor = begin + static_cast<std::uint64_t>(clock);
    const std::uint64_t step = 100'000'000 / sensor_.columns;
    OusterSweep sweep;
    for (std::size_t first = 0; first < sensor_.columns; first += sensor_.columns_per_packet) {
      const auto measured = [&](std::size_t column, std::size_t pixel) {
        return at(column, pixel);
      };
      const std::uint64_t end = begin + (first + sensor_.columns_per_packet - 1) * step;
      sweep.packets.push_back(
          {ros::Time().fromNSec(end),
           {ouster_packet(sensor_, frame, first, by_sensor + first * step, step, measured)}});
    }
    std_msgs::Header header = plain_.header;
    header.frame_id = "os_lidar";
    std::vector<TimedPoint> points;
    for (std::size_t column = 0; column < sensor_.columns; ++column) {
      for (std::size_t pixel = 0; pixel < 16; ++pixel) {
        const OusterReturn value = at(column, pixel);
        if (value.counts == 0) continue;
        const Eigen::Vector3f p = sensor_.point(column, pixel, value.counts).cast<float>();
        points.push_back({p.x(), p.y(), p.z(), static_cast<float>(value.reflectivity),
                          static_cast<float>(1e-9 * static_cast<double>(column * step))});
      }
    }
    sweep.cloud = plain_cloud(header, points);
    return sweep;
  }

 private:
  OusterReturn at(std::size_t column, std::size_t pixel) const {
    return measured_[16 * column + pixel];
  }
  /// The sensor looks backwards: its column 0 is where the simulated turn begins.
  void add(const TimedPoint& point) {
    const Eigen::Vector3d p(-point.x, -point.y, point.z);
    const double elevation = std::asin(p.z() / p.norm()) * kDegPerRad;
    for (std::size_t pixel = 0; pixel < 16; ++pixel) {
      if (std::abs(sensor_.altitudes_deg[pixel] - elevation) > 0.9) continue;
      // By the formula of OusterSensor::point(), without the small offset of the beam's origin.
      const double encoder =
          std::atan2(p.y(), p.x()) * kDegPerRad + sensor_.azimuths_deg[pixel] + 720.0;
      const auto columns = static_cast<double>(sensor_.columns);
      const auto column =
          static_cast<std::size_t>(std::lround((720.0 + 360.0 - encoder) / 360.0 * columns)) %
          sensor_.columns;
      measured_[16 * column + pixel] = {static_cast<std::uint32_t>(std::lround(1e3 * p.norm())),
                                        static_cast<std::uint8_t>(point.intensity)};
    }
  }

  sensor_msgs::PointCloud2 plain_;
  OusterSensor sensor_;
  std::vector<OusterReturn> measured_;
};

}  // namespace lidar_mapping::test
