// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"

#include "driver_messages.hpp"
#include "figures.hpp"
#include "hesai_messages.hpp"
#include "ouster_packet_message.hpp"
#include "ouster_turn.hpp"
#include "preprocessing_fixture.hpp"
#include "velodyne_encoder.hpp"

namespace lidar_mapping::test {
namespace {

using ros_border::to_ros;

/// A node of its own, whose points come from a driver's type.
template <typename Message>
class NodeWithDriver {
 public:
  NodeWithDriver()
      : node_("preprocessing_node", {"_max_latency:=0.1"}),
        clouds_(connected_publisher<Message>("points")) {
    EXPECT_TRUE(wait_until([] { return is_connected("points") && is_connected("synced_cloud"); }));
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "lidar";
    transform.transform.rotation.w = 1.0;
    transforms_.sendTransform(transform);
  }
  void send(const Message& message) { clouds_.publish(message); }
  Listener<sensor_msgs::PointCloud2>& synced() { return synced_; }

 private:
  NodeProcess node_;
  ros::Publisher clouds_;
  tf2_ros::StaticTransformBroadcaster transforms_;
  Listener<sensor_msgs::PointCloud2> synced_{"synced_cloud"};
};

TEST(PreprocessingNodeWithDriver, ReadsLivoxCustomMsg) {
  using Livox = LivoxMessage<LivoxDriver::kTwo>;
  NodeWithDriver<Livox> node;
  for (int step = 0; step < 3; ++step) {
    Livox message;
    message.header.stamp = to_ros(stamp_of(step));
    message.header.frame_id = "lidar";
    for (std::uint32_t i = 0; i < 200; ++i) {
      message.points.push_back({i * 500'000U, 5.0F, 0.01F * static_cast<float>(i), 1.0F, 77, 0, 0});
    }
    node.send(message);
  }
  ASSERT_TRUE(node.synced().wait_for(3));
  const PointCloud cloud = ros_border::from_message(node.synced().messages[1]);
  ASSERT_EQ(cloud.size(), 200U);
  EXPECT_EQ(cloud.points[100].x, 5.0F);
  EXPECT_EQ(cloud.points[100].intensity, 77.0F);
  EXPECT_NEAR(cloud.times[100], 0.05, 1e-6);
}

/// A turn of a VLP-16 that sees 5 m everywhere.
VelodyneScanMessage velodyne_turn(int step) {
  VelodyneScanMessage message;
  message.header.stamp = to_ros(stamp_of(step));
  message.header.frame_id = "lidar";
  message.packets.resize(75);
  for (std::size_t p = 0; p < message.packets.size(); ++p) {
    const auto microseconds = static_cast<std::uint32_t>(1333 * p);
    message.packets[p].stamp = message.header.stamp + ros::Duration(1e-6 * microseconds);
    for (std::size_t b = 0; b < 12; ++b) {
      put_block(message.packets[p].data, b, static_cast<std::uint16_t>(40 * (12 * p + b)),
                [](std::size_t) {
                  return VelodyneReturn{2500, 9};
                });
    }
    put_end(message.packets[p].data, microseconds, kStrongest, kIsVlp16);
  }
  return message;
}

TEST(PreprocessingNodeWithDriver, ReadsPacketsOfAVelodyne) {
  NodeWithDriver<VelodyneScanMessage> node;
  for (int step = 0; step < 3; ++step) node.send(velodyne_turn(step));
  ASSERT_TRUE(node.synced().wait_for(3));
  const PointCloud cloud = ros_border::from_message(node.synced().messages[1]);
  ASSERT_EQ(cloud.size(), 75U * 12U * 32U);
  EXPECT_NEAR(cloud.points[7000].position().norm(), 5.0, 1e-4);
  ASSERT_TRUE(cloud.has_times());
  EXPECT_NEAR(cloud.times.back() - cloud.times.front(), 0.1, 2e-3);
}

/// A turn of a PandarXT-16 that sees 5 m everywhere, without a stamp, as hesai_lidar sends it.
PandarScanMessage<PandarDriver::kHesaiLidar> hesai_turn(int step) {
  PandarScanMessage<PandarDriver::kHesaiLidar> message;
  message.header.frame_id = "lidar";
  for (std::size_t p = 0; p < 250; ++p) {
    std::vector<HesaiBlock> blocks;
    for (std::size_t b = 0; b < 8; ++b) {
      blocks.push_back({static_cast<std::uint16_t>(18 * (8 * p + b)), [](std::size_t) {
                          return HesaiReturn{1250, 9};
                        }});
    }
    const auto microseconds = static_cast<std::uint32_t>(400 * p);
    message.packets.emplace_back(to_ros(stamp_of(step)) + ros::Duration(1e-6 * microseconds),
                                 HesaiPacketWriter(kPandarXt16).write(blocks, microseconds));
  }
  return message;
}

TEST(PreprocessingNodeWithDriver, ReadsPacketsOfAHesai) {
  NodeWithDriver<PandarScanMessage<PandarDriver::kHesaiLidar>> node;
  for (int step = 0; step < 3; ++step) node.send(hesai_turn(step));
  ASSERT_TRUE(node.synced().wait_for(3));
  const PointCloud cloud = ros_border::from_message(node.synced().messages[1]);
  ASSERT_EQ(cloud.size(), 250U * 8U * 16U);
  EXPECT_NEAR(cloud.points[7000].position().norm(), 5.0, 1e-4);
  ASSERT_TRUE(cloud.has_times());
  EXPECT_NEAR(cloud.times.back() - cloud.times.front(), 0.1, 2e-3);
}

/// A node of its own that is given what the driver of an Ouster publishes, by the clock of ROS, in
/// the time that a sensor takes.
class NodeWithOuster {
 public:
  /// `points` and `others`: where the packets come.
  explicit NodeWithOuster(const std::string& points = "/ouster/lidar_packets",
                          std::vector<std::string> others = {})
      : node_("preprocessing_node", arguments(points, std::move(others))),
        points_(connected_publisher<OusterPacketMessage>(points)),
        metadata_topic_(points.substr(0, points.rfind('/')) + "/metadata") {
    EXPECT_TRUE(wait_until([&] {
      return is_connected(points) && is_connected("synced_cloud") && is_connected("tf_static");
    }));
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.transform.rotation.w = 1.0;
    std::vector<geometry_msgs::TransformStamped> transforms;
    for (const char* frame : {"os_lidar", "os_imu"}) {
      transform.child_frame_id = frame;
      transforms.push_back(transform);
    }
    transforms_.sendTransform(transforms);
    begin_ = ros_border::from_ros(ros::Time::now());
  }
  void send_metadata() {
    metadata_ = connected_publisher<std_msgs::String>(metadata_topic_);
    std_msgs::String text;
    text.data = sensor_.metadata();
    metadata_.publish(text);
  }
  /// The packets of a turn up to `end`, and ten of the IMU, on a topic of it.
  void send_turn(int turn, std::size_t end, const ros::Publisher& imu = {}) {
    wait_until([] { return false; }, 0.1);
    for (std::size_t index = 0; index < end; ++index) send_packet(turn, index);
    if (!imu) return;
    for (int i = 0; i < 10; ++i) {
      const Stamp stamp = time_of(turn) + i * kPeriod / 10;
      imu.publish(OusterPacketMessage{ouster_imu_packet(static_cast<std::uint64_t>(stamp),
                                                        {0.0, 0.0, 1.0}, {0.0, 0.0, kTurning})});
    }
  }
  void send_turn(int turn, const ros::Publisher& imu = {}) {
    send_turn(turn, packets_in_turn(sensor_), imu);
  }
  void send_packet(int turn, std::size_t index) {
    points_.publish(
        OusterPacketMessage{packet_of_turn(sensor_, static_cast<std::uint16_t>(kFirstTurn + turn),
                                           index, static_cast<std::uint64_t>(time_of(turn)))});
  }
  Stamp time_of(int turn) const { return begin_ + turn * kPeriod; }

  const NodeProcess& node() const { return node_; }
  Listener<sensor_msgs::PointCloud2>& synced() { return synced_; }
  Listener<sensor_msgs::Imu>& synced_imu() { return synced_imu_; }

  static constexpr double kTurning = 10.0;           // degrees/s
  static constexpr int kFirstTurn = 30'000;          // of a sensor that has been running
  static constexpr std::size_t kPoints = 128U * 4U;  // of a turn

 private:
  static std::vector<std::string> arguments(const std::string& points,
                                            std::vector<std::string> others) {
    others.insert(others.end(), {"_max_latency:=0.1", "points:=" + points});
    return others;
  }
  static OusterSensor sensor() {
    OusterSensor sensor;
    sensor.columns = 128;
    sensor.altitudes_deg = {-15.0, -5.0, 0.0, 10.0};
    sensor.azimuths_deg = {0.0, 0.0, 0.0, 0.0};
    return sensor;
  }

  const OusterSensor sensor_ = sensor();
  NodeProcess node_;
  ros::Publisher points_, metadata_;
  std::string metadata_topic_;
  tf2_ros::StaticTransformBroadcaster transforms_;
  Listener<sensor_msgs::PointCloud2> synced_{"synced_cloud"};
  Listener<sensor_msgs::Imu> synced_imu_{"synced_imu"};
  Stamp begin_ = 0;
};

/// A turn of the sensor; where the turn lies in time hangs on how busy the machine is.
void expect_a_turn(const sensor_msgs::PointCloud2& message) {
  EXPECT_EQ(message.header.frame_id, "os_lidar");
  const PointCloud cloud = ros_border::from_message(message);
  ASSERT_EQ(cloud.size(), NodeWithOuster::kPoints);
  EXPECT_NEAR(cloud.points[300].position().norm(), kOusterRange, 2e-3);
  ASSERT_TRUE(cloud.has_times());
  EXPECT_NEAR(cloud.times.back() - cloud.times.front(), 0.1, 2e-3);
}

TEST(PreprocessingNodeWithDriver, ReadsPacketsOfAnOusterAndOfItsImu) {
  NodeWithOuster node;
  node.send_metadata();
  const auto imu = connected_publisher<OusterPacketMessage>("/ouster/imu_packets");
  for (int turn = 0; turn < 5; ++turn) node.send_turn(turn, imu);
  ASSERT_TRUE(node.synced().wait_for(5)) << node.node().output();
  for (const auto& message : node.synced().messages) expect_a_turn(message);
  EXPECT_TRUE(node.synced_imu().wait_for(1)) << node.node().output();
}

/// Of a topic that was renamed the type says what it holds.
TEST(PreprocessingNodeWithDriver, ReadsPacketsOfAnOusterThatComeBeforeTheirMetadata) {
  NodeWithOuster node("/roof/points", {"imu:=/roof/gyro"});
  const auto imu = connected_publisher<OusterPacketMessage>("/roof/gyro");
  for (int turn = 0; turn < 3; ++turn) node.send_turn(turn, imu);
  EXPECT_TRUE(node.synced().messages.empty());
  node.send_metadata();
  for (int turn = 3; turn < 600 && node.synced().messages.size() < 5; ++turn) {
    node.send_turn(turn, imu);
  }
  ASSERT_GE(node.synced().messages.size(), 5U) << node.node().output();
  for (const auto& message : node.synced().messages) expect_a_turn(message);
  EXPECT_TRUE(node.synced_imu().wait_for(1)) << node.node().output();
}

TEST(PreprocessingNodeWithDriver, NamesTheMissingMetadataOfAnOuster) {
  Diagnostics diagnostics("/diagnostics");
  NodeWithOuster node;
  int turn = 0;
  const auto send_until = [&](const std::function<bool()>& condition) {
    for (int i = 0; i < 600 && !condition(); ++i) node.send_turn(turn++);
    return condition();
  };
  const std::string line =
      "no scans yet: packets of an Ouster come on /ouster/lidar_packets, but no metadata that can "
      "be used on /ouster/metadata";
  ASSERT_TRUE(send_until([&] { return node.node().says(line); })) << node.node().output();
  EXPECT_TRUE(reports(diagnostics, "packets before the metadata", "[1-9][0-9]*"));
  node.send_metadata();
  EXPECT_TRUE(send_until([&] { return !node.synced().messages.empty(); })) << node.node().output();
  EXPECT_EQ(node.node().count(line), 1U) << node.node().output();
}

/// "No message has arrived" was said of ten in a second.
TEST(PreprocessingNodeWithDriver, SaysWhatIsWrongWithCloudsThatItCannotRead) {
  constexpr double kLongerThanTheWatchWaits = 7.0;  // s
  Diagnostics diagnostics("/diagnostics");
  NodeWithDriver<sensor_msgs::PointCloud2> node;
  int step = 0;
  const auto send = [&] {
    sensor_msgs::PointCloud2 cloud =
        ros_border::to_message(yard_seen_from(straight(step), 7U), stamp_of(step), "lidar");
    cloud.is_bigendian = 1U;
    node.send(cloud);
    ++step;
  };
  send_until(
      send, [] { return false; }, kLongerThanTheWatchWaits);
  std::string states;
  for (const auto& message : diagnostics.messages) states += message.status.at(0).message + "\n";
  EXPECT_NE(states.find("/points: cloud: big-endian data"), std::string::npos) << states;
  EXPECT_EQ(states.find("no message has arrived"), std::string::npos) << states;
}

TEST(PreprocessingNodeWithDriver, CountsPacketsOfAnOusterThatAreInNoCloud) {
  Diagnostics diagnostics("/diagnostics");
  NodeWithOuster node;
  node.send_metadata();
  for (int turn = 0; turn < 3; ++turn) node.send_turn(turn);
  node.send_packet(1, 7);
  node.send_turn(3, 5);
  EXPECT_TRUE(reports(diagnostics, "packets late", "1"));
  EXPECT_TRUE(reports(diagnostics, "packets of an unfinished turn", "5"));
  EXPECT_TRUE(wait_until([&] {
    return diagnostics.messages.back().status.at(0).message ==
           "packets left out: 1 late, 5 of an unfinished turn";
  }));
  EXPECT_TRUE(node.synced().wait_for(3)) << node.node().output();
}

/// An IMU that the vehicle has beside the LiDAR's.
TEST(PreprocessingNodeWithDriver, PrefersTheTopicOfTheImuToThePacketsOfAnOuster) {
  NodeWithOuster node;
  node.send_metadata();
  const auto packets = connected_publisher<OusterPacketMessage>("/ouster/imu_packets");
  const auto imu = connected_publisher<sensor_msgs::Imu>("imu");
  for (int turn = 0; turn < 5; ++turn) {
    const Stamp now = ros_border::from_ros(ros::Time::now());
    for (int sample = -9; sample <= 0; ++sample) {
      sensor_msgs::Imu message;
      message.header = ros_border::header_of(now + sample * kPeriod / 10, "os_lidar");
      message.orientation_covariance[0] = -1.0;
      message.angular_velocity.z = 1.0;
      message.linear_acceleration.z = 9.81;
      imu.publish(message);
    }
    node.send_turn(turn, packets);
  }
  ASSERT_TRUE(node.synced().wait_for(5)) << node.node().output();
  EXPECT_TRUE(node.synced_imu().wait_for(1)) << node.node().output();
  for (const auto& message : node.synced_imu().messages) {
    EXPECT_NEAR(message.angular_velocity.z, 1.0, 0.1);
  }
}

/// The check of the inputs ends after some seconds; damage does not.
TEST(PreprocessingNodeWithDriver, CountsDamagedPacketsOfTheWholeDrive) {
  Diagnostics diagnostics("/diagnostics");
  NodeWithDriver<VelodyneScanMessage> node;
  for (const int step : {0, 100, 101}) {
    VelodyneScanMessage message = velodyne_turn(step);
    put_number(message.packets[10].data, 300, 0x1234, 2);  // the flag of a block
    node.send(message);
  }
  EXPECT_TRUE(reports(diagnostics, "packets damaged", "3"));
}

TEST_F(PreprocessingNode, TakesWheelOdometryAndGeoPoints) {
  node_->kill();  // a subscription stays with the type that it has met first
  gnss_.shutdown();
  ros::NodeHandle handle;
  const auto geo_points = handle.advertise<ros_border::GeoPointStamped>("gnss", 1000);
  const auto odometry = handle.advertise<nav_msgs::Odometry>("velocity", 1000);
  Listener<geometry_msgs::TwistStamped> synced_velocity("synced_velocity");
  node_ = start();
  ASSERT_TRUE(wait_until([&] {
    return node_->is_running() && connected() && is_connected("velocity") &&
           is_connected("synced_velocity");
  }));
  send_transform();
  for (int half_step = 0; half_step < 20; ++half_step) {
    nav_msgs::Odometry wheels;
    wheels.header.stamp = to_ros(kBegin + half_step * kPeriod / 2);
    wheels.header.frame_id = "odom";
    wheels.child_frame_id = "base_link";
    wheels.twist.twist.linear.x = 1.0;
    odometry.publish(wheels);
    ros_border::GeoPointStamped fix{wheels.header, 49.0, 8.4, 100.0};
    fix.header.frame_id = "lidar";
    geo_points.publish(fix);
    if (half_step % 2 == 1) send_cloud(half_step / 2);
  }
  ASSERT_TRUE(synced_velocity.wait_for(5)) << node_->output();
  EXPECT_NEAR(synced_velocity.messages.back().twist.linear.x, 1.0, 1e-9);
  ASSERT_TRUE(datum_.wait_for(1)) << node_->output();
  EXPECT_NEAR(datum_.messages.back().altitude, 100.0, 1e-9);
}

/// hdl_graph_slam's enable_robot_odometry_init_guess, and a receiver without a driver for fixes.
TEST_F(PreprocessingNode, TakesTransformsOfAWheelOdometryAndSentencesOfAReceiver) {
  node_->kill();
  gnss_.shutdown();
  ros::NodeHandle handle;
  const auto sentences = handle.advertise<ros_border::NmeaSentence>("gnss", 1000);
  const auto transforms = handle.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  Listener<geometry_msgs::TwistStamped> synced_velocity("synced_velocity");
  node_ = std::make_unique<NodeProcess>(
      "preprocessing_node",
      std::vector<std::string>{"_max_latency:=2.0", "_enable_robot_odometry_init_guess:=true",
                               "_robot_odom_frame_id:=wheels"});
  ASSERT_TRUE(wait_until([&] {
    return node_->is_running() && connected() && is_connected("/tf") &&
           is_connected("synced_velocity");
  }));
  send_transform();
  for (int half_step = 0; half_step < 20; ++half_step) {
    const Stamp stamp = kBegin + half_step * kPeriod / 2;
    const Pose T_wheels_base{Eigen::Quaterniond::Identity(), {0.1 * half_step, 0.0, 0.0}};
    tf2_msgs::TFMessage message;
    message.transforms = {
        ros_border::stamped_transform(T_wheels_base, stamp, "wheels", "base_link")};
    transforms.publish(message);
    ros_border::NmeaSentence sentence;
    sentence.header.stamp = to_ros(stamp);
    sentence.header.frame_id = "lidar";
    sentence.sentence = "$GPRMC,123519,A,4900.000,N,00824.000,E,022.4,084.4,230394,,";
    sentences.publish(sentence);
    sentence.sentence = "$GPGGA,123519,4900.000,N,00824.000,E,1,08,0.9,60.0,M,40.0,M,,";
    sentences.publish(sentence);
    if (half_step % 2 == 1) send_cloud(half_step / 2);
  }
  ASSERT_TRUE(synced_velocity.wait_for(5)) << node_->output();
  EXPECT_NEAR(synced_velocity.messages.back().twist.linear.x, 2.0, 1e-6);
  ASSERT_TRUE(datum_.wait_for(1)) << node_->output();
  EXPECT_NEAR(datum_.messages.back().altitude, 100.0, 1e-6);
  EXPECT_FALSE(node_->says("which is not read")) << node_->output();
}

TEST_F(PreprocessingNode, RefusesItsOwnOdometryAsThatOfTheWheels) {
  NodeProcess other("preprocessing_node", {"__name:=other", "_robot_odom_frame_id:=odom",
                                           "_enable_robot_odometry_init_guess:=true"});
  EXPECT_EQ(other.wait(), 1);
  EXPECT_TRUE(other.says("robot_odom_frame_id: 'odom'")) << other.output();
}

/// Whether the node names the type of a message that is published as a velocity.
template <typename Message>
bool names_type_of_velocity(const NodeProcess& node) {
  const auto publisher = connected_publisher<Message>("velocity");
  const std::string type = ros::message_traits::DataType<Message>::value();
  return wait_until([&] {
    publisher.publish(Message());
    return node.says("/velocity holds " + type + ", which is not read");
  });
}

TEST_F(PreprocessingNode, NamesATypeThatItDoesNotRead) {
  EXPECT_TRUE(names_type_of_velocity<geometry_msgs::PoseStamped>(*node_)) << node_->output();
}

TEST_F(PreprocessingNode, NamesATypeThatItReadsFromAnotherTopic) {
  EXPECT_TRUE(names_type_of_velocity<sensor_msgs::NavSatFix>(*node_)) << node_->output();
}

}  // namespace
}  // namespace lidar_mapping::test
