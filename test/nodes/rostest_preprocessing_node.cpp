// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <csignal>
#include <set>

#include <geometry_msgs/TwistStamped.h>
#include <ros/master.h>
#include <std_msgs/UInt32.h>

#include "figures.hpp"
#include "preprocessing_fixture.hpp"

namespace lidar_mapping::test {
namespace {

using ros_border::from_ros;
using ros_border::to_ros;

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

TEST_F(PreprocessingNode, CountsTheCloudsOfOtherLidarsThatItLeavesOut) {
  Diagnostics diagnostics("/diagnostics");
  const auto others = connected_publisher<sensor_msgs::PointCloud2>("other_points");
  send_transform();
  others.publish(timed_yard(0, 0, "nowhere"));
  others.publish(timed_yard(1, 0, "nowhere"));
  EXPECT_TRUE(reports(diagnostics, "clouds of other LiDARs left out", "2")) << node_->output();
}

// Late tf, the LiDAR with and without other sensors, stamps bit for bit.
TEST_F(PreprocessingNode, WaitsForTheTransformAndKeepsStamps) {
  for (int step = 0; step < 5; ++step) send_cloud(step);
  EXPECT_FALSE(synced_.wait_for(1, 0.1));
  send_transform();
  drive(5, 10);
  ASSERT_TRUE(synced_.wait_for(10));
  for (int step = 0; step < 10; ++step) {
    const auto& message = synced_.messages[step];
    EXPECT_EQ(from_ros(message.header.stamp), stamp_of(step));
    EXPECT_EQ(message.header.frame_id, "lidar");
  }
  ASSERT_TRUE(synced_imu_.wait_for(5));
  ASSERT_TRUE(synced_gnss_.wait_for(5));
  EXPECT_EQ(from_ros(synced_imu_.messages.back().header.stamp), stamp_of(9));
  EXPECT_EQ(from_ros(synced_gnss_.messages.back().header.stamp), stamp_of(9));
  EXPECT_TRUE(node_->is_running());
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
  Diagnostics diagnostics("/diagnostics");
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
  Diagnostics diagnostics("/diagnostics");
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

/// It was silent, or repeated that nobody publishes the points.
TEST_F(PreprocessingNode, SaysInItsDiagnosticsWhyItPublishesNoScan) {
  Diagnostics diagnostics("/diagnostics");
  for (int step = 0; step < 3; ++step) send_cloud(step);
  EXPECT_TRUE(wait_until([&] {
    return !diagnostics.messages.empty() &&
           diagnostics.messages.back().status.at(0).message == "scans dropped: 3 without transform";
  })) << node_->output();
  EXPECT_TRUE(synced_.messages.empty());
}

/// The most frequent fault of all: a topic of another name.
TEST_F(PreprocessingNode, NamesPossibleTopicsIfNoMessageArrives) {
  clouds_.shutdown();
  const auto other = ros::NodeHandle().advertise<sensor_msgs::PointCloud2>("velodyne_points", 1);
  EXPECT_TRUE(wait_until([&] {
    return node_->says(
        "nobody publishes /points; topics of sensor_msgs/PointCloud2 that "
        "are published: /velodyne_points (choose one with "
        "points:=TOPIC)");
  })) << node_->output();
}

/// Only the points are needed: a velocity under another name was left out without a word.
TEST_F(PreprocessingNode, NamesASensorThatIsPublishedUnderAnotherName) {
  const auto wheels = ros::NodeHandle().advertise<geometry_msgs::TwistStamped>("wheel_speed", 1);
  send_transform();
  drive(0, 5);
  EXPECT_TRUE(wait_until([&] {
    return node_->says(
        "velocity: nobody publishes /velocity, so the map is made without; "
        "published and not used: /wheel_speed");
  })) << node_->output();
  EXPECT_FALSE(node_->says("imu: nobody")) << "it is there";
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
  EXPECT_TRUE(node_->says("never came: 6 (by their numbers), 6 of them before the first one"))
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
