// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/wire_message.hpp"

#include "cloud_forms.hpp"
#include "error_text.hpp"
#include "hesai_messages.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

using test::LivoxDriver;
using test::TimedPoint;

sensor_msgs::PointCloud2 example() {
  std_msgs::Header header;
  header.stamp = ros::Time(1700000000, 250000000);
  header.frame_id = "/lidar";
  std::vector<TimedPoint> points;
  for (int i = 0; i < 100; ++i) {
    const auto f = static_cast<float>(i);
    points.push_back({f, 2.0F * f, -f, f, 0.001F * f});
  }
  return test::plain_cloud(header, points);
}

template <typename Message>
std::vector<std::uint8_t> serialized(const Message& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

template <typename Message>
RecordedCloud cloud_in(const std::vector<std::uint8_t>& bytes) {
  const std::string type = ros::message_traits::DataType<Message>::value();
  const std::string md5sum = ros::message_traits::MD5Sum<Message>::value();
  EXPECT_TRUE(is_cloud(type, md5sum)) << type;
  return read_cloud(type, md5sum, {bytes.data(), bytes.size()}, nullptr);
}

template <typename Message>
void expect_example(const Message& message) {
  const std::vector<std::uint8_t> bytes = serialized(message);
  const preprocessing::PreprocessingConfig config;
  for (const bool lazily : {false, true}) {
    const RecordedCloud cloud = cloud_in<Message>(bytes);
    const CloudReader reader(config);
    DecodedCloud decoded = lazily ? reader.read_lazily(cloud) : reader.read(cloud);
    decoded.scan.unpack();
    EXPECT_EQ(decoded.scan.stamp, 1700000000250000000);
    EXPECT_EQ(decoded.scan.frame_id, "lidar");
    ASSERT_EQ(decoded.scan.cloud.size(), 100U);
    EXPECT_EQ(decoded.scan.cloud.points[7].position(), Eigen::Vector3f(7, 14, -7));
    EXPECT_EQ(decoded.scan.cloud.points[7].intensity, 7.0F);
    ASSERT_TRUE(decoded.scan.cloud.has_times());
    EXPECT_NEAR(decoded.scan.cloud.times[99], 0.099, 1e-6);
  }
}

/// Any shortening of a message is noticed.
template <typename Message>
void expect_cuts_noticed(const Message& message) {
  const std::vector<std::uint8_t> bytes = serialized(message);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    const std::vector<std::uint8_t> cut(bytes.begin(),
                                        bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(cloud_in<Message>(cut), ros::Exception) << size;
  }
}

TEST(RecordedCloud, ReadsEachType) {
  expect_example(example());
  expect_example(test::with_split_times(example()));
  expect_example(test::as_livox<LivoxDriver::kOne>(example()));
  expect_example(test::as_livox<LivoxDriver::kTwo>(example()));
  expect_example(test::as_point_cloud1(example()));
}

using test::PandarDriver;

/// Three packets, the last of them the calibration, and a header without stamp and frame.
template <PandarDriver driver>
test::PandarScanMessage<driver> hesai_scan() {
  test::PandarScanMessage<driver> scan;
  for (std::size_t p = 0; p < 2; ++p) {
    std::vector<test::HesaiBlock> blocks;
    for (std::size_t b = 0; b < 8; ++b) {
      blocks.push_back({static_cast<std::uint16_t>(18 * (8 * p + b)), [](std::size_t) {
                          return test::HesaiReturn{1250, 77};
                        }});
    }
    const auto passed = static_cast<std::uint32_t>(400 * p);
    scan.packets.emplace_back(
        ros::Time(1700000000, 250000000 + 1000 * passed),
        test::HesaiPacketWriter(test::kPandarXt16).write(blocks, 250'000 + passed));
  }
  std::string calibration = "Channel,Elevation,Azimuth\n";
  for (int i = 1; i <= 16; ++i) calibration += std::to_string(i) + ",-30,90\n";
  scan.packets.emplace_back(ros::Time(), test::hesai_calibration_packet(calibration));
  return scan;
}

template <PandarDriver driver>
void expect_hesai_scan() {
  const auto bytes = serialized(hesai_scan<driver>());
  const RecordedCloud cloud = cloud_in<test::PandarScanMessage<driver>>(bytes);
  EXPECT_TRUE(cloud.holds_packets());
  const DecodedCloud decoded = CloudReader({}).read(cloud);
  EXPECT_EQ(decoded.scan.stamp, 1700000000250000000);
  EXPECT_EQ(decoded.scan.frame_id, "PandarXT-16");
  EXPECT_EQ(decoded.format.contents, "2 packets of a Hesai PandarXT-16");
  EXPECT_EQ(decoded.format.damaged_packets, 0U);
  ASSERT_EQ(decoded.scan.cloud.size(), 256U);
  // The calibration has the azimuth at x and the elevation at 30 degrees down.
  EXPECT_NEAR(decoded.scan.cloud.points[0].x, 5.0 * std::sqrt(0.75), 1e-3);
  EXPECT_NEAR(decoded.scan.cloud.points[0].z, -2.5, 1e-5);
  EXPECT_NEAR(decoded.scan.cloud.times[128], 1e-6 * (400.0 + 5.632 - 350.0 + 0.368), 1e-8);
}

TEST(RecordedCloud, ReadsPacketsOfAHesaiAndCompletesTheirHeader) {
  expect_hesai_scan<PandarDriver::kHesaiLidar>();
  expect_hesai_scan<PandarDriver::kPandarMsgs>();
}

TEST(RecordedCloud, LeavesTheHeaderOfAHesaiThatIsThere) {
  auto scan = hesai_scan<PandarDriver::kPandarMsgs>();
  scan.header.stamp = ros::Time(1700000000, 251000000);
  scan.header.frame_id = "/pandar";
  const auto bytes = serialized(scan);
  const DecodedCloud decoded =
      CloudReader({}).read(cloud_in<test::PandarScanMessage<PandarDriver::kPandarMsgs>>(bytes));
  EXPECT_EQ(decoded.scan.stamp, 1700000000251000000);
  EXPECT_EQ(decoded.scan.frame_id, "pandar");
  EXPECT_NEAR(decoded.scan.cloud.times[128], 1e-6 * (400.0 + 5.632 - 350.0 + 0.368 - 1000.0), 1e-8);
}

/// A size beyond its place is that of no packet.
TEST(RecordedCloud, KeepsToThePlaceOfAPacketOfAHesai) {
  auto scan = hesai_scan<PandarDriver::kPandarMsgs>();
  scan.packets[1].size = 4'000'000'000;
  const auto bytes = serialized(scan);
  const DecodedCloud decoded =
      CloudReader({}).read(cloud_in<test::PandarScanMessage<PandarDriver::kPandarMsgs>>(bytes));
  EXPECT_EQ(decoded.format.damaged_packets, 1U);
  EXPECT_EQ(decoded.scan.cloud.size(), 128U);
}

TEST(RecordedCloud, NoticesCutMessages) {
  expect_cuts_noticed(test::as_livox<LivoxDriver::kOne>(example()));
  expect_cuts_noticed(test::as_point_cloud1(example()));
  test::VelodyneScanMessage scan;
  scan.packets.resize(3);
  expect_cuts_noticed(scan);
  expect_cuts_noticed(hesai_scan<PandarDriver::kHesaiLidar>());
  expect_cuts_noticed(hesai_scan<PandarDriver::kPandarMsgs>());
}

/// A count of four thousand million is no reason to ask for that much memory.
TEST(RecordedCloud, NoticesCountsBeyondTheMessage) {
  auto livox = test::as_livox<LivoxDriver::kOne>(example());
  std::vector<std::uint8_t> bytes = serialized(livox);
  const std::size_t count_at = bytes.size() - livox.points.size() * 19 - 4;
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(count_at), 4, std::uint8_t{0xFF});
  EXPECT_THROW(cloud_in<test::LivoxMessage<LivoxDriver::kOne>>(bytes), ros::Exception);
}

TEST(RecordedCloud, LeavesOutChannelsWithoutAValueForEachPoint) {
  sensor_msgs::PointCloud cloud = test::as_point_cloud1(example());
  cloud.channels[1].values.pop_back();
  const auto bytes = serialized(cloud);
  const DecodedCloud decoded = CloudReader({}).read(cloud_in<sensor_msgs::PointCloud>(bytes));
  EXPECT_EQ(decoded.format.fields, "x y z intensity");
  EXPECT_FALSE(decoded.scan.cloud.has_times());
}

TEST(RecordedCloud, ReadsNoOtherType) {
  EXPECT_THROW(read_cloud("sensor_msgs/LaserScan", "", {}, nullptr), InputError);
  EXPECT_THROW(read_cloud("pandar_msgs/PandarScan", "0", {}, nullptr), InputError);
  EXPECT_FALSE(is_cloud("sensor_msgs/LaserScan", "90c7ef2dc6895d81024acba2ac42f369"));
  EXPECT_FALSE(is_cloud("velodyne_msgs/VelodyneScan", "0"));
  EXPECT_EQ(foreign_definition("velodyne_msgs/VelodyneScan", "0"),
            "velodyne_msgs/VelodyneScan of another definition (MD5 sum 0, read is "
            "50804fc9533a0e579e6322c04ae70566)");
  EXPECT_EQ(foreign_definition("hesai_lidar/PandarScan", ""),
            "hesai_lidar/PandarScan of another definition (that of ROS 2, read is "
            "70c3ed4f4ae9144323298b04cc2c760b or 96facf9d6e028e0cacbe7058fbabc851)");
  EXPECT_EQ(foreign_definition("sensor_msgs/LaserScan", "0"), "");
}

TEST(CloudReader, NeedsACalibrationThatIsThere) {
  preprocessing::PreprocessingConfig config;
  config.velodyne_calibration = "/no/such/file.yaml";
  EXPECT_THROW(CloudReader{config}, FileError);
  config.velodyne_calibration = "";
  config.hesai_calibration = "/no/such/file.csv";
  EXPECT_THROW(CloudReader{config}, FileError);
}

/// No shell puts the home folder for ~ in a file of parameters.
TEST(CloudReader, FindsACalibrationInTheHomeFolder) {
  const test::TemporaryFolder home;
  const std::string before = std::getenv("HOME") != nullptr ? std::getenv("HOME") : "";
  setenv("HOME", home.path().c_str(), 1);
  preprocessing::PreprocessingConfig config;
  config.hesai_calibration = "~/none.csv";
  const std::string problem = test::error_text<FileError>([&] { CloudReader{config}; });
  setenv("HOME", before.c_str(), 1);
  EXPECT_NE(problem.find(home.path().string() + "/none.csv"), std::string::npos) << problem;
}

TEST(WireMessage, TakesTheBytesAndTheNumber) {
  sensor_msgs::PointCloud2 cloud = example();
  cloud.header.seq = 42;
  std::vector<std::uint8_t> bytes = serialized(cloud);
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  WireMessage message;
  EXPECT_EQ(message.sequence(), 0U);
  ros::serialization::deserialize(stream, message);
  EXPECT_EQ(message.data, bytes);
  EXPECT_EQ(message.sequence(), 42U);
}

TEST(WireMessage, GivesAMessageOfItsType) {
  namespace traits = ros::message_traits;
  const sensor_msgs::PointCloud2 cloud = example();
  WireMessage message;
  message.type = traits::DataType<sensor_msgs::PointCloud2>::value();
  message.data = serialized(cloud);
  EXPECT_FALSE(message.is<sensor_msgs::PointCloud2>()) << "another definition";
  message.md5sum = traits::MD5Sum<sensor_msgs::PointCloud2>::value();
  EXPECT_TRUE(message.is<sensor_msgs::PointCloud2>());
  EXPECT_FALSE(message.is<sensor_msgs::PointCloud>());
  EXPECT_EQ(message.instantiate<sensor_msgs::PointCloud2>(), cloud);
  message.data.pop_back();
  EXPECT_THROW(message.instantiate<sensor_msgs::PointCloud2>(), ros::Exception);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
