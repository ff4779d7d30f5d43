// SPDX-License-Identifier: BSD-3-Clause
// The example files that are recordings, with the calibrations of their sensors.
#include <fstream>

#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/nmea_sentence.hpp"

#include "../ros/cloud_builder.hpp"
#include "cloud_forms.hpp"
#include "example_files.hpp"
#include "example_points.hpp"
#include "hesai_messages.hpp"
#include "mcap_writer.hpp"
#include "ouster_messages.hpp"
#include "ros2_writer.hpp"

namespace lidar_mapping::test {

namespace {

namespace fs = std::filesystem;

sensor_msgs::PointCloud2 cloud(const ros::Time& stamp) {
  constexpr std::uint8_t kFloat = sensor_msgs::PointField::FLOAT32;
  sensor_msgs::PointCloud2 message =
      xyz_cloud({{"intensity", kFloat, 12}, {"time", kFloat, 16}}, 20, 60, stamp);
  for (std::size_t i = 0; i < message.width; ++i)
    put(message, i, 16, 0.001F * static_cast<float>(i));
  return message;
}

}  // namespace

void write_bag(const fs::path& path, rosbag::compression::CompressionType compression) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(4000);
  tf2_msgs::TFMessage frames;
  for (const char* frame : {"lidar", "imu", "gps"}) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = ros::Time(100);
    transform.header.frame_id = "base_link";
    transform.child_frame_id = frame;
    transform.transform.rotation.w = 1.0;
    frames.transforms.push_back(transform);
  }
  bag.write("/tf_static", ros::Time(100), frames);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    sensor_msgs::Imu imu;
    imu.header.stamp = now;
    imu.header.frame_id = "imu";
    imu.linear_acceleration.z = 9.81;
    imu.orientation.w = 1.0;
    bag.write("/imu", now, imu);
    geometry_msgs::TwistStamped velocity;
    velocity.header = imu.header;
    velocity.twist.linear.x = 5.0;
    bag.write("/velocity", now, velocity);
    sensor_msgs::NavSatFix fix;
    fix.header.stamp = now;
    fix.header.frame_id = "gps";
    fix.latitude = 49.0 + 1e-6 * i;
    fix.longitude = 8.0;
    bag.write("/fix", now, fix);
    bag.write("/points", now, cloud(now));
  }
  bag.close();
}

void write_bag_of_other_types(const fs::path& path) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  bag.setCompression(rosbag::compression::LZ4);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    ros_border::NmeaSentence sentence;
    sentence.header.stamp = now;
    sentence.header.frame_id = "gps";
    sentence.sentence = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47";
    bag.write("/sentences", now, sentence);
    geometry_msgs::TwistWithCovarianceStamped velocity;
    velocity.header = sentence.header;
    velocity.twist.twist.linear.x = 5.0;
    bag.write("/velocity", now, velocity);
    tf2_msgs::TFMessage frames;
    frames.transforms.resize(1);
    frames.transforms[0].header.stamp = now;
    frames.transforms[0].header.frame_id = "odom";
    frames.transforms[0].child_frame_id = "base_link";
    frames.transforms[0].transform.rotation.w = 1.0;
    bag.write("/tf", now, frames);
    bag.write("/points", now, cloud(now));
  }
  bag.close();
}

namespace {

VelodyneScanMessage velodyne_scan(const ros::Time& now) {
  VelodyneScanMessage scan;
  scan.header.stamp = now;
  scan.header.frame_id = "lidar";
  scan.packets.resize(3);
  for (std::size_t p = 0; p < scan.packets.size(); ++p) {
    const auto microseconds = static_cast<std::uint32_t>(1327 * p);
    scan.packets[p].stamp = now + ros::Duration(1e-6 * microseconds);
    for (std::size_t b = 0; b < 12; ++b) {
      put_block(scan.packets[p].data, b, static_cast<std::uint16_t>(40 * (12 * p + b)),
                [](std::size_t channel) {
                  return VelodyneReturn{static_cast<std::uint16_t>(2000 + channel), 9};
                });
    }
    put_end(scan.packets[p].data, microseconds, kStrongest, kIsVlp16);
  }
  return scan;
}

std::string hesai_channels() {
  std::string text = "Channel,Elevation,Azimuth\n";
  for (int i = 1; i <= 16; ++i) {
    text += std::to_string(i) + "," + std::to_string(17 - 2 * i) + ",-0.25\n";
  }
  return text;
}

/// Packets in dual return mode, and the calibration beside them.
template <PandarDriver driver>
PandarScanMessage<driver> hesai_scan(const ros::Time& now) {
  PandarScanMessage<driver> scan;
  if (driver == PandarDriver::kPandarMsgs) scan.header.stamp = now;
  scan.header.frame_id = "lidar";
  for (std::size_t p = 0; p < 3; ++p) {
    std::vector<HesaiBlock> blocks;
    for (std::size_t b = 0; b < 8; ++b) {
      blocks.push_back({static_cast<std::uint16_t>(18 * (4 * p + b / 2)), [b](std::size_t laser) {
                          return HesaiReturn{static_cast<std::uint16_t>(2000 + b * laser), 9};
                        }});
    }
    const auto microseconds = static_cast<std::uint32_t>(200 * p);
    scan.packets.emplace_back(now + ros::Duration(1e-6 * microseconds),
                              HesaiPacketWriter(kPandarXt16).write(blocks, microseconds));
  }
  scan.packets.emplace_back(now, hesai_calibration_packet(hesai_channels()));
  return scan;
}

/// Some packets of a turn and one of the IMU, and before the first ones the metadata.
void write_ouster_turn(rosbag::Bag& bag, const ros::Time& now, std::uint32_t turn) {
  OusterSensor sensor;
  sensor.columns = 32;
  sensor.altitudes_deg = sensor.azimuths_deg = {2.0, 0.5, -1.0};
  std_msgs::String metadata;
  metadata.data = sensor.metadata();
  if (turn == 0) bag.write("/os/metadata", now, metadata);
  const std::uint64_t step = 3'000'000;  // ns
  for (std::size_t first = 0; first < sensor.columns; first += sensor.columns_per_packet) {
    const std::uint64_t begin = now.toNSec() + first * step;
    const OusterPacketMessage packet{
        ouster_packet(sensor, static_cast<std::uint16_t>(turn), first, begin, step,
                      [](std::size_t column, std::size_t pixel) {
                        return OusterReturn{static_cast<std::uint32_t>(3000 + column + pixel), 9};
                      })};
    bag.write("/os/lidar_packets", ros::Time().fromNSec(begin + 8 * step), packet);
  }
  const OusterPacketMessage imu{ouster_imu_packet(now.toNSec(), {0.0, 0.0, 1.0}, {0.0, 0.0, 5.0})};
  bag.write("/os/imu_packets", now, imu);
}

sensor_msgs::PointCloud2 timed_cloud(const ros::Time& now) {
  std_msgs::Header header;
  header.stamp = now;
  header.frame_id = "lidar";
  std::vector<TimedPoint> timed;
  for (const Point& p : example_points())
    timed.push_back({p.x, p.y, p.z, p.intensity, 0.001F * p.intensity});
  return plain_cloud(header, timed);
}

}  // namespace

void write_bag_of_driver(const fs::path& path, const std::string& driver) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  for (std::uint32_t i = 0; i < 10; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    const sensor_msgs::PointCloud2 cloud = timed_cloud(now);
    if (driver == "livox") bag.write("/points", now, as_livox<LivoxDriver::kTwo>(cloud));
    if (driver == "velodyne") bag.write("/points", now, velodyne_scan(now));
    if (driver == "hesai") bag.write("/points", now, hesai_scan<PandarDriver::kHesaiLidar>(now));
    if (driver == "pandar") bag.write("/points", now, hesai_scan<PandarDriver::kPandarMsgs>(now));
    if (driver == "ouster") write_ouster_turn(bag, now, i);
    if (driver == "point_cloud1") bag.write("/points", now, as_point_cloud1(cloud));
    if (driver == "split_times") bag.write("/points", now, with_split_times(cloud));
  }
  bag.close();
}

namespace {

template <typename Writer>
void fill_ros2_recording(Writer& out) {
  for (std::uint32_t i = 0; i < 10; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    tf2_msgs::TFMessage frames;
    frames.transforms.resize(1);
    frames.transforms[0].header.stamp = now;
    frames.transforms[0].header.frame_id = "base_link";
    frames.transforms[0].child_frame_id = "lidar";
    frames.transforms[0].transform.rotation.w = 1.0;
    out.add("/tf", now, frames);
    sensor_msgs::Imu imu;
    imu.header.stamp = now;
    imu.header.frame_id = "lidar";
    imu.linear_acceleration.z = 9.81;
    imu.orientation.w = 1.0;
    out.add("/imu", now, imu);
    out.add("/points", now, timed_cloud(now));
  }
}

}  // namespace

void write_ros2_recording(const fs::path& path) {
  Ros2Writer out(path);
  fill_ros2_recording(out);
}

void write_mcap_recording(const fs::path& path, const std::string& compression) {
  McapOptions options;
  options.compression = compression;
  // Damage is to reach what is read behind the checksums, too.
  options.has_checksums = compression == "lz4";
  options.has_summary = compression != "zstd";
  McapWriter out(path, options);
  fill_ros2_recording(out);
}

void write_velodyne_calibration(const fs::path& path) {
  std::ofstream file(path);
  file << "num_lasers: 16\ndistance_resolution: 0.002\nlasers:\n";
  for (int id = 0; id < 16; ++id) {
    file << "- {laser_id: " << id << ", rot_correction: 0.01, vert_correction: " << 0.03 * id - 0.2
         << ", dist_correction: 0.1, dist_correction_x: 0.12, dist_correction_y: 0.11, "
            "two_pt_correction_available: true, vert_offset_correction: 0.02, "
            "horiz_offset_correction: 0.026, focal_distance: 12, focal_slope: 1.4}\n";
  }
}

void write_hesai_calibration(const fs::path& path) { std::ofstream(path) << hesai_channels(); }

}  // namespace lidar_mapping::test
