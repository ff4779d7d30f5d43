// SPDX-License-Identifier: BSD-3-Clause
// Recordings of ROS 2 through the commands, without ROS 2.
#include <fstream>
#include <map>

#include "hesai_messages.hpp"
#include "input_forms.hpp"
#include "mcap_writer.hpp"
#include "ros2_writer.hpp"

namespace lidar_mapping::tools {
namespace {

using sensor_msgs::PointCloud2;
using test::kTopic;
using test::LivoxDriver;
using test::McapOptions;
using test::McapWriter;
using test::Ros2Writer;

class Ros2Recordings : public test::InputForms {
 protected:
  /// The drive as a recording of ROS 2; clouds are written by `write`.
  template <typename WriteCloud>
  std::string recorded(const std::string& path, const WriteCloud& write) const {
    Ros2Writer out(path);
    record(out, write);
    return path;
  }
  std::string recorded_as_mcap(const std::string& path, const McapOptions& options) const {
    McapWriter out(path, options);
    record(out, write_plain<McapWriter>);
    return path;
  }
  template <typename Writer>
  static void write_plain(Writer& out, const ros::Time& recorded, const PointCloud2& cloud) {
    out.add(kTopic, recorded, cloud);
  }

 private:
  template <typename Writer, typename WriteCloud>
  void record(Writer& out, const WriteCloud& write) const {
    const rosbag::Bag in(drive(), rosbag::bagmode::Read);
    for (const rosbag::MessageInstance& message : rosbag::View(in)) {
      if (const auto cloud = message.instantiate<PointCloud2>()) {
        write(out, message.getTime(), *cloud);
      } else {
        copy<sensor_msgs::Imu, sensor_msgs::NavSatFix, geometry_msgs::TwistStamped,
             tf2_msgs::TFMessage, nav_msgs::Odometry>(message, out);
      }
    }
  }
  template <typename... Messages, typename Writer>
  static void copy(const rosbag::MessageInstance& from, Writer& to) {
    (copy_one<Messages>(from, to), ...);
  }
  template <typename Message, typename Writer>
  static void copy_one(const rosbag::MessageInstance& from, Writer& to) {
    const auto message = from.instantiate<Message>();
    if (message) to.add(from.getTopic(), from.getTime(), *message);
  }
};

TEST_F(Ros2Recordings, AFileAndAFolderGiveThePosesOfTheBag) {
  const std::filesystem::path folder = folder_.path() / "drive";
  std::filesystem::create_directory(folder);
  std::ofstream(folder / "metadata.yaml") << "rosbag2_bagfile_information:\n  version: 5\n";
  const std::string file = recorded(folder / "drive_0.db3", write_plain<Ros2Writer>);
  const Trajectory plain = plain_poses();
  expect_equal_poses(mapped(file), plain);
  expect_equal_poses(mapped(folder), plain);
  expect_said(checked(folder), "points    /points: 10.0 Hz, frame velo_link", 0);
  for (const char* topic : {"/kitti/oxts/imu: 100.0 Hz", "/kitti/oxts/gps/vel", "/gps/fix: 10.0"}) {
    EXPECT_TRUE(has_said(topic));
  }
}

TEST_F(Ros2Recordings, LivoxCustomMsg) {
  const auto livox = [](Ros2Writer& out, const ros::Time& recorded, const PointCloud2& cloud) {
    out.add(kTopic, recorded, test::as_livox<LivoxDriver::kTwo>(cloud));
  };
  const std::string file = recorded(folder_.path() / "livox.db3", livox);
  expect_equal_poses(mapped(file), plain_poses());
}

/// pandar_msgs as ROS 2 stores it.
using PandarScan = test::PandarScanMessage<test::PandarDriver::kPandarMsgs>;
std::vector<std::uint8_t> cdr_of(const PandarScan& scan) {
  test::CdrWriter out;
  out.header(scan.header);
  out.number(static_cast<std::uint32_t>(scan.packets.size()));
  for (const auto& packet : scan.packets) {
    out.stamp(packet.stamp);
    out.array(packet.data);
    out.number(packet.size);
  }
  return out.bytes();
}

TEST_F(Ros2Recordings, PacketsOfAHesai) {
  const auto turn_of = [](const PointCloud2& cloud) {
    return test::HesaiTurnWriter(cloud).write();
  };
  const auto packets = [&](Ros2Writer& out, const ros::Time& recorded, const PointCloud2& cloud) {
    out.add_bytes(kTopic, "pandar_msgs/msg/PandarScan", recorded,
                  cdr_of(turn_of(cloud).message<test::PandarDriver::kPandarMsgs>()));
  };
  const auto clouds = [&](Ros2Writer& out, const ros::Time& recorded, const PointCloud2& cloud) {
    out.add(kTopic, recorded, turn_of(cloud).cloud);
  };
  const std::string file = recorded(folder_.path() / "packets.db3", packets);
  expect_equal_poses(mapped(file), mapped(recorded(folder_.path() / "clouds.db3", clouds)));
}

TEST_F(Ros2Recordings, McapFilesGiveThePosesOfTheBag) {
  const Trajectory plain = plain_poses();
  for (const char* compression : {"", "lz4", "zstd"}) {
    McapOptions options;
    options.compression = compression;
    options.chunk_bytes = 800'000;  // as rosbag2 has it
    const std::filesystem::path folder = folder_.path() / ("drive" + options.compression);
    std::filesystem::create_directory(folder);
    const std::string file = recorded_as_mcap(folder / "drive_0.mcap", options);
    expect_equal_poses(mapped(file), plain);
    if (options.compression == "zstd") expect_equal_poses(mapped(folder), plain);
    expect_said(checked(file), "points    /points: 10.0 Hz, frame velo_link", 0);
  }
}

TEST_F(Ros2Recordings, ACutMcapFileIsMappedUpToThereAndNamed) {
  McapOptions options;
  options.chunk_bytes = 800'000;
  const std::string file = recorded_as_mcap(folder_.path() / "cut.mcap", options);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) * 3 / 4);
  EXPECT_GT(mapped(file).poses.size(), 40U);
  expect_said(checked(file), "its end is missing, from byte ", 1);
  std::filesystem::resize_file(file, 20);
  expect_said(checked(file), "no topic of the recording holds clouds", 1);
}

TEST_F(Ros2Recordings, WhatCannotBeReadIsNamed) {
  const std::string type = "sensor_msgs/msg/PointCloud2";
  const auto written = [&](const std::string& name, std::vector<std::uint8_t> bytes,
                           const std::string& format = "cdr") {
    Ros2Writer(folder_.path() / name).add_bytes(kTopic, type, ros::Time(100), bytes, format);
    return (folder_.path() / name).string();
  };
  expect_said(checked(written("xcdr.db3", {0, 7, 0, 0, 1, 2, 3, 4})),
              "not serialised as little-endian CDR", 1);
  expect_said(checked(written("zstd.db3", {0x28, 0xB5, 0x2F, 0xFD, 1, 2, 3})),
              "ros2 bag convert decompresses", 1);
  expect_said(checked(written("cut.db3", {0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 200, 0, 0, 0})),
              "shorter than its counts say", 1);
  expect_said(checked(written("other.db3", {}, "protobuf")), "serialised as 'protobuf'", 2);
  std::ofstream(folder_.path() / "a.db3.zstd") << "\x28\xB5\x2F\xFD and more than sixteen bytes";
  expect_said(checked(folder_.path() / "a.db3.zstd"), "zstd -d decompresses it", 2);
  std::ofstream(folder_.path() / "b.db3") << std::string("SQLite format 3\0 and no pages", 30);
  expect_said(checked(folder_.path() / "b.db3"), "cannot read the recording", 2);
}

TEST_F(Ros2Recordings, RawDataOfOtherDriversIsNamedWithItsRemedy) {
  const std::map<std::string, std::string> remedies = {
      {"ouster_ros/PacketMsg", "record the driver's topic metadata beside them"},
      {"hesai_ros_driver/UdpFrame", "hesai_ros_driver (source_type 3)"},
      {"rslidar_msgs/rslidarScan", "rslidar_sdk (msg_source 2)"}};
  for (const auto& [type, remedy] : remedies) {
    const std::string file = folder_.path() / (type.substr(0, type.find('/')) + ".mcap");
    std::string ros2_type = type;
    ros2_type.insert(ros2_type.find('/'), "/msg");
    McapWriter(file, {}).add_bytes("/packets", ros2_type, ros::Time(100), {0, 1, 0, 0});
    expect_said(checked(file), "/packets holds " + type + ", not a cloud", 1);
    EXPECT_TRUE(has_said(remedy));
  }
}

/// hesai_lidar has no header in its messages of ROS 2.
TEST_F(Ros2Recordings, ATypeWithOtherFieldsThanInRos1IsNamed) {
  const std::string file = folder_.path() / "hesai.mcap";
  McapWriter(file, {}).add_bytes("/packets", "hesai_lidar/msg/PandarScan", ros::Time(100),
                                 {0, 1, 0, 0});
  expect_said(checked(file),
              "/packets holds hesai_lidar/PandarScan of another definition (that of ROS 2", 1);
  EXPECT_TRUE(has_said("publish the sensor's data as sensor_msgs/PointCloud2"));
}

TEST_F(Ros2Recordings, ACutFileIsNamed) {
  const std::string file = recorded(folder_.path() / "whole.db3", write_plain<Ros2Writer>);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  expect_said(checked(file), "cannot read the recording " + file, 2);
}

}  // namespace
}  // namespace lidar_mapping::tools
