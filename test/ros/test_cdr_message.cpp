// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/common/errors.hpp"

#include "bags/cdr_message.hpp"
#include "bags/ros2_types.hpp"
#include "ros2_writer.hpp"

namespace lidar_mapping::ros_border {
namespace {

/// The message after it has been a message of ROS 2.
template <typename Message>
Message through_ros2(const Message& message, const std::string& type) {
  test::CdrWriter out;
  test::write(out, message);
  const Ros2Type* known = ros2_type(type);
  EXPECT_NE(known, nullptr) << type;
  EXPECT_EQ(known->md5sum, ros::message_traits::MD5Sum<Message>::value());
  std::vector<std::uint8_t> bytes =
      from_cdr({out.bytes().data(), out.bytes().size()}, known->layout);
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  Message read;
  ros::serialization::deserialize(stream, read);
  EXPECT_EQ(stream.getLength(), 0U);
  return read;
}

/// Names of all lengths, so that what follows is aligned in all ways.
TEST(CdrMessage, AlignsNumbersBehindTexts) {
  for (std::size_t length = 0; length < 20; ++length) {
    sensor_msgs::NavSatFix fix;
    fix.header.stamp = ros::Time(1700000000, 5);
    fix.header.frame_id = std::string(length, 'g');
    fix.status.status = -1;
    fix.status.service = 513;
    fix.latitude = 49.5;
    fix.longitude = -8.25;
    fix.altitude = 110.0;
    for (std::size_t i = 0; i < 9; ++i) fix.position_covariance[i] = 0.5 * static_cast<double>(i);
    fix.position_covariance_type = 3;
    EXPECT_EQ(through_ros2(fix, "sensor_msgs/msg/NavSatFix"), fix) << length;
    nav_msgs::Odometry odometry;
    odometry.header = fix.header;
    odometry.child_frame_id = std::string(length % 7, 'b');
    odometry.pose.pose.orientation.w = 1.0;
    odometry.twist.twist.linear.x = 3.5;
    odometry.twist.covariance[35] = 7.0;
    EXPECT_EQ(through_ros2(odometry, "nav_msgs/msg/Odometry"), odometry) << length;
  }
}

TEST(CdrMessage, ReadsListsOfMessagesAndEmptyOnes) {
  tf2_msgs::TFMessage frames;
  EXPECT_EQ(through_ros2(frames, "tf2_msgs/msg/TFMessage"), frames);
  frames.transforms.resize(3);
  frames.transforms[0].child_frame_id = "a";
  frames.transforms[1].header.frame_id = "longer";
  frames.transforms[2].transform.translation.z = -2.5;
  EXPECT_EQ(through_ros2(frames, "tf2_msgs/msg/TFMessage"), frames);
}

TEST(CdrMessage, RefusesWhatIsShorterThanItSays) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.fields.resize(2);
  cloud.data.resize(50);
  test::CdrWriter out;
  test::write(out, cloud);
  const MessageLayout& layout = ros2_type("sensor_msgs/msg/PointCloud2")->layout;
  for (std::size_t size = 0; size < out.bytes().size(); ++size) {
    const std::vector<std::uint8_t> cut(out.bytes().begin(),
                                        out.bytes().begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(from_cdr({cut.data(), cut.size()}, layout), InputError) << size;
  }
}

TEST(CdrMessage, KnowsTheTypesByTheirNames) {
  EXPECT_EQ(ros2_type("sensor_msgs/msg/LaserScan"), nullptr);
  EXPECT_EQ(name_in_ros1("sensor_msgs/msg/LaserScan"), "sensor_msgs/LaserScan");
  EXPECT_EQ(name_in_ros1("odd"), "odd");
  EXPECT_EQ(ros2_type("livox_interfaces/msg/CustomMsg")->ros1_name, "livox_ros_driver2/CustomMsg");
  EXPECT_EQ(ros2_type("velodyne_msgs/msg/VelodyneScan")->ros1_name, "velodyne_msgs/VelodyneScan");
  EXPECT_EQ(ros2_type("pandar_msgs/msg/PandarScan")->md5sum, "96facf9d6e028e0cacbe7058fbabc851");
  EXPECT_EQ(ros2_type("hesai_lidar/msg/PandarScan"), nullptr);  // it has no header
}

}  // namespace
}  // namespace lidar_mapping::ros_border
