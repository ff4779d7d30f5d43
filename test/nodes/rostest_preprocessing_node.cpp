// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <csignal>
#include <set>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/master.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/UInt32.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"

#include "driver_messages.hpp"
#include "listener.hpp"
#include "node_process.hpp"
#include "velodyne_encoder.hpp"
#include "yard.hpp"

namespace lidar_mapping::test {
namespace {

using ros_border::from_ros;
using ros_border::to_ros;

constexpr Stamp kBegin = 1317384506123456789;
constexpr Stamp kPeriod = 100000000;

Stamp stamp_of(int step) { return kBegin + step * kPeriod; }

class PreprocessingNode : public testing::Test {
 protected:
  PreprocessingNode()
      : node_(start()),
        clouds_(connected_publisher<sensor_msgs::PointCloud2>("points")),
        imu_(connected_publisher<sensor_msgs::Imu>("imu")),
        gnss_(connected_publisher<sensor_msgs::NavSatFix>("gnss")) {
    EXPECT_TRUE(wait_until([&] { return connected(); }));
  }

  static std::unique_ptr<NodeProcess> start() {
    return std::make_unique<NodeProcess>("preprocessing_node",
                                         std::vector<std::string>{"_max_latency:=2.0"});
  }
  bool connected() const {
    for (const char* topic : {"points", "imu", "gnss", "tf_static", "synced_cloud", "synced_imu",
                              "synced_gnss", "gnss_datum"}) {
      if (!is_connected(topic)) return false;
    }
    return true;
  }
  /// Scans with an IMU and a fix before and after each.
  void drive(int begin, int end) {
    for (int step = begin; step < end; ++step) {
      send_samples(stamp_of(step) - kPeriod / 2);
      send_cloud(step);
    }
    send_samples(stamp_of(end - 1) + kPeriod / 2);
  }

  void send_cloud(int step) {
    clouds_.publish(
        ros_border::to_message(yard_seen_from(straight(step), 7U), stamp_of(step), "lidar"));
  }
  void send_samples(Stamp stamp) {
    sensor_msgs::Imu imu;
    imu.header.stamp = to_ros(stamp);
    imu.header.frame_id = "/lidar";  // as tf 1 wrote it
    imu.orientation.w = 1.0;
    imu.linear_acceleration.z = 9.81;
    imu_.publish(imu);
    sensor_msgs::NavSatFix fix;
    fix.header = imu.header;
    fix.latitude = latitude_;
    fix.longitude = 8.4;
    gnss_.publish(fix);
  }
  void send_transform() {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "lidar";
    transform.transform.translation.z = 2.0;
    transform.transform.rotation.w = 1.0;
    transforms_.sendTransform(transform);
  }

  double latitude_ = 49.0;
  std::unique_ptr<NodeProcess> node_;
  ros::Publisher clouds_, imu_, gnss_;
  tf2_ros::StaticTransformBroadcaster transforms_;
  Listener<sensor_msgs::PointCloud2> synced_{"synced_cloud"};
  Listener<sensor_msgs::Imu> synced_imu_{"synced_imu"};
  Listener<nav_msgs::Odometry> synced_gnss_{"synced_gnss"};
  Listener<sensor_msgs::NavSatFix> datum_{"gnss_datum"};
};

/// A scan whose points have times, in a frame.
sensor_msgs::PointCloud2 timed_yard(int step, Stamp late, const std::string& frame) {
  PointCloud cloud = yard_seen_from(straight(step), 7U);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.times.push_back(0.09F * static_cast<float>(i) / static_cast<float>(cloud.size()));
  }
  return ros_border::to_message(cloud, stamp_of(step) + late, frame);
}

TEST_F(PreprocessingNode, MergesTheCloudsOfOtherLidars) {
  ros::Publisher others = connected_publisher<sensor_msgs::PointCloud2>("other_points");
  send_transform();
  clouds_.publish(timed_yard(0, 0, "lidar"));
  ASSERT_TRUE(synced_.wait_for(1));  // alone it does not wait for another scan
  const std::uint32_t alone = synced_.messages[0].width;
  const auto is_merged = [&] {
    const auto& messages = synced_.messages;
    return std::any_of(messages.begin(), messages.end(),
                       [&](const auto& message) { return message.width > alone + alone / 2; });
  };
  // Topics have no order among each other: the other cloud may come after its scan has gone on.
  for (int step = 1; step < 50 && !is_merged(); ++step) {
    others.publish(timed_yard(step, -kPeriod / 2, "lidar"));
    clouds_.publish(timed_yard(step, 0, "lidar"));
    ASSERT_TRUE(synced_.wait_for(static_cast<std::size_t>(step)));  // one scan may wait
  }
  EXPECT_TRUE(is_merged());
}

// Late tf, the LiDAR with and without other sensors, stamps bit for bit.
TEST_F(PreprocessingNode, WaitsForTheTransformAndKeepsStamps) {
  for (int step = 0; step < 5; ++step) send_cloud(step);
  EXPECT_FALSE(synced_.wait_for(1, 0.1));
  send_transform();
  drive(5, 10);
  ASSERT_TRUE(synced_.wait_for(10));
  for (int step = 0; step < 10; ++step) {
    const auto& message = synced_.messages[static_cast<std::size_t>(step)];
    EXPECT_EQ(from_ros(message.header.stamp), stamp_of(step));
    EXPECT_EQ(message.header.frame_id, "lidar");
  }
  ASSERT_TRUE(synced_imu_.wait_for(5));
  ASSERT_TRUE(synced_gnss_.wait_for(5));
  EXPECT_EQ(from_ros(synced_imu_.messages.back().header.stamp), stamp_of(9));
  EXPECT_EQ(from_ros(synced_gnss_.messages.back().header.stamp), stamp_of(9));
  EXPECT_TRUE(node_->is_running());
}

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

TEST(PreprocessingNodeWithDriver, ReadsPacketsOfAVelodyne) {
  NodeWithDriver<VelodyneScanMessage> node;
  for (int step = 0; step < 3; ++step) {
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
    node.send(message);
  }
  ASSERT_TRUE(node.synced().wait_for(3));
  const PointCloud cloud = ros_border::from_message(node.synced().messages[1]);
  ASSERT_EQ(cloud.size(), 75U * 12U * 32U);
  EXPECT_NEAR(cloud.points[7000].position().norm(), 5.0, 1e-4);
  ASSERT_TRUE(cloud.has_times());
  EXPECT_NEAR(cloud.times.back() - cloud.times.front(), 0.1, 2e-3);
}

/// The master of this test, which does not answer as long as this object lives.
class StoppedMaster {
 public:
  StoppedMaster() {
    XmlRpc::XmlRpcValue caller, answer, pid;
    caller[0] = ros::this_node::getName();
    if (ros::master::execute("getPid", caller, answer, pid, false)) pid_ = static_cast<int>(pid);
    if (pid_ > 0) ::kill(pid_, SIGSTOP);
  }
  ~StoppedMaster() {
    if (pid_ > 0) ::kill(pid_, SIGCONT);
  }
  StoppedMaster(const StoppedMaster&) = delete;
  StoppedMaster& operator=(const StoppedMaster&) = delete;
  bool is_stopped() const { return pid_ > 0; }

 private:
  pid_t pid_ = -1;
};

// Nothing is asked of the master while scans go through, once it knows the datum of the run.
TEST_F(PreprocessingNode, NeedsNoMasterForItsScans) {
  Listener<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  send_transform();
  drive(0, 5);
  ASSERT_TRUE(synced_.wait_for(5));
  // The first report asks for the interval of the reports, once.
  ASSERT_TRUE(wait_until([&] {
    return !diagnostics.messages.empty() &&
           !diagnostics.messages.back().status.at(0).values.empty();
  })) << node_->output();
  // On a busy machine all five scans may be there before the first fix is.
  ASSERT_TRUE(datum_.wait_for(1)) << node_->output();
  const StoppedMaster master;
  ASSERT_TRUE(master.is_stopped());
  drive(5, 25);
  EXPECT_TRUE(synced_.wait_for(25)) << node_->output();
  EXPECT_EQ(from_ros(synced_.messages.back().header.stamp), stamp_of(24));
}

/// What the input validator found and what waits in the queue of a topic have names of their own.
TEST_F(PreprocessingNode, ReportsEachFigureOnceAfterItHasLookedAtTheInput) {
  Listener<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  send_transform();
  drive(0, 55);
  ASSERT_TRUE(synced_.wait_for(50)) << node_->output();
  std::multiset<std::string> keys;
  ASSERT_TRUE(wait_until([&] {
    keys.clear();
    if (diagnostics.messages.empty()) return false;
    for (const auto& value : diagnostics.messages.back().status.at(0).values)
      keys.insert(value.key);
    return keys.count("points") > 0;
  })) << node_->output();
  for (const std::string& key : keys) EXPECT_EQ(keys.count(key), 1U) << key;
  EXPECT_EQ(keys.count("queue points"), 1U);
}

/// The most frequent fault of all: a topic of another name.
TEST_F(PreprocessingNode, NamesTheTopicsThatCouldBeMeantWhereNothingComes) {
  clouds_.shutdown();
  const auto other = ros::NodeHandle().advertise<sensor_msgs::PointCloud2>("velodyne_points", 1);
  EXPECT_TRUE(wait_until([&] {
    return node_->output().find(
               "nobody publishes /points; topics of sensor_msgs/PointCloud2 that "
               "are published: /velodyne_points (choose one with "
               "points:=TOPIC)") != std::string::npos;
  })) << node_->output();
}

/// Only the points are needed: a velocity under another name was left out without a word.
TEST_F(PreprocessingNode, NamesASensorThatIsPublishedUnderAnotherName) {
  const auto wheels = ros::NodeHandle().advertise<geometry_msgs::TwistStamped>("wheel_speed", 1);
  send_transform();
  drive(0, 5);
  EXPECT_TRUE(wait_until([&] {
    return node_->output().find(
               "velocity: nobody publishes /velocity, so the map is made without; "
               "published and not used: /wheel_speed") != std::string::npos;
  })) << node_->output();
  EXPECT_EQ(node_->output().find("imu: nobody"), std::string::npos) << "it is there";
}

/// As `rosbag play` does, which sends before everybody is connected.
TEST_F(PreprocessingNode, CountsTheScansOfARecordingThatNobodyGot) {
  node_->stop();
  ASSERT_TRUE(wait_until([&] { return clouds_.getNumSubscribers() == 0; }));
  for (int step = 0; step < 6; ++step) send_cloud(step);
  ros::param::set("/use_sim_time", true);
  node_ = start();
  ASSERT_TRUE(wait_until([&] { return node_->is_running() && connected(); }));
  ros::param::del("/use_sim_time");
  Listener<std_msgs::UInt32> lost("scans_lost");
  send_transform();
  drive(6, 10);
  ASSERT_TRUE(synced_.wait_for(4)) << node_->output();
  ASSERT_TRUE(lost.wait_for(1)) << node_->output();
  EXPECT_EQ(lost.messages.back().data, 6U);
  EXPECT_NE(
      node_->output().find("never came: 6 (by their numbers), 6 of them before the first one"),
      std::string::npos)
      << node_->output();
}

/// The map's frame would jump otherwise.
TEST_F(PreprocessingNode, KeepsTheDatumWhenItWasKilled) {
  send_transform();
  drive(0, 5);
  ASSERT_TRUE(datum_.wait_for(1));
  node_->kill();
  node_ = start();
  ASSERT_TRUE(wait_until([&] { return node_->is_running() && connected(); }));
  synced_gnss_.messages.clear();
  latitude_ = 49.001;
  drive(20, 25);
  ASSERT_TRUE(synced_gnss_.wait_for(5)) << node_->output();
  ASSERT_TRUE(datum_.wait_for(2));
  EXPECT_NEAR(datum_.messages.back().latitude, 49.0, 1e-12);
  EXPECT_NEAR(synced_gnss_.messages.back().pose.pose.position.y, 111.2, 0.2);
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
    geometry_msgs::TransformStamped wheels;
    wheels.header.stamp = to_ros(stamp);
    wheels.header.frame_id = "wheels";
    wheels.child_frame_id = "base_link";
    wheels.transform =
        ros_border::to_transform(Pose{Eigen::Quaterniond::Identity(), {0.1 * half_step, 0.0, 0.0}});
    tf2_msgs::TFMessage message;
    message.transforms = {wheels};
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
  EXPECT_EQ(node_->output().find("which is not read"), std::string::npos) << node_->output();
}

TEST_F(PreprocessingNode, RefusesItsOwnOdometryAsThatOfTheWheels) {
  NodeProcess other("preprocessing_node", {"__name:=other", "_robot_odom_frame_id:=odom",
                                           "_enable_robot_odometry_init_guess:=true"});
  EXPECT_EQ(other.wait(), 1);
  EXPECT_NE(other.output().find("robot_odom_frame_id: 'odom'"), std::string::npos)
      << other.output();
}

TEST_F(PreprocessingNode, NamesATypeThatItDoesNotRead) {
  const auto twist = connected_publisher<geometry_msgs::PoseStamped>("velocity");
  ASSERT_TRUE(wait_until([] { return is_connected("velocity"); }));
  EXPECT_TRUE(wait_until([&] {
    twist.publish(geometry_msgs::PoseStamped());
    return node_->output().find("/velocity holds geometry_msgs/PoseStamped, which is not read") !=
           std::string::npos;
  })) << node_->output();
}

// Clouds without points or cut off.
TEST_F(PreprocessingNode, SurvivesUnusableClouds) {
  send_transform();
  sensor_msgs::PointCloud2 empty;
  empty.header.frame_id = "lidar";
  empty.header.stamp = to_ros(stamp_of(0));
  clouds_.publish(empty);
  auto cut = ros_border::to_message(yard_seen_from(straight(1), 7U), stamp_of(1), "lidar");
  cut.data.resize(cut.data.size() / 2);
  clouds_.publish(cut);
  for (int step = 2; step < 8; ++step) send_cloud(step);
  ASSERT_TRUE(synced_.wait_for(6));
  EXPECT_EQ(from_ros(synced_.messages.front().header.stamp), stamp_of(2));
  EXPECT_TRUE(node_->is_running());
}

}  // namespace
}  // namespace lidar_mapping::test
