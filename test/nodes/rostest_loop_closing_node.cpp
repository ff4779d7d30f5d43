// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"

#include "listener.hpp"
#include "near.hpp"
#include "node_process.hpp"
#include "yard.hpp"

namespace lidar_mapping::test {
namespace {

constexpr int kCount = 60;

/// Out and back on the same line.
Pose true_pose(int index) { return straight(index < kCount / 2 ? index : kCount - 1 - index, 0.8); }

/// 2 m between key frames, with odometry that drifts sideways.
KeyFrame key_frame_at(int index) {
  const Pose T_map_base = true_pose(index);
  KeyFrame key_frame;
  key_frame.index = static_cast<KeyFrameIndex>(index);
  key_frame.stamp = 1317384506123456789 + index * 400000000LL;
  key_frame.T_odom_base = T_map_base;
  key_frame.T_odom_base.translation.y() += 0.02 * index;
  key_frame.motion_covariance = diagonal_covariance(0.05, 0.005);
  key_frame.cloud =
      std::make_shared<PointCloud>(yard_seen_from(T_map_base, static_cast<unsigned>(index)));
  return key_frame;
}

/// A back end that has all key frames of a finished drive.
class LoopClosingNode : public testing::Test {
 protected:
  LoopClosingNode() {
    for (int i = 0; i < kCount; ++i) {
      stored_.push_back(ros_border::to_message(key_frame_at(i), "run", "base_link"));
    }
    const boost::function<bool(GetKeyFrames::Request&, GetKeyFrames::Response&)> answer =
        [this](GetKeyFrames::Request& request, GetKeyFrames::Response& response) {
          return serve(request, response);
        };
    service_ = ros::NodeHandle().advertiseService("get_key_frames", answer);
  }

  /// Nothing is given before this test hears all that the node says of it.
  bool serve(const GetKeyFrames::Request& request, GetKeyFrames::Response& response) {
    if (!wait_for_links()) return false;
    response.poses.run_id = "run";
    response.poses.whole = true;
    response.loops = loops_that_are_known_;
    response.gnss = fixes_that_are_known_;
    response.antennas.resize(fixes_that_are_known_.size());
    response.searched = searched_;
    for (const KeyFrameMessage& message : stored_) {
      const bool wanted = request.indices.empty() ||
                          std::count(request.indices.begin(), request.indices.end(), message.index);
      if (!wanted) continue;
      response.key_frames.push_back(message);
      if (!request.clouds) response.key_frames.back().cloud = {};
    }
    ++requests_;
    return true;
  }

  /// Called within a callback: links come up without any.
  bool wait_for_links() const {
    return wait_within_callback([&] { return loops_.connected() && verdicts_.connected(); });
  }

  /// Small yards and short ways: what real drives need would find nothing here.
  const std::vector<std::string> arguments_ = {"_diff_num:=10", "_loop_step:=1",
                                               "_accum_distance_thresh:=10.0"};
  std::vector<KeyFrameMessage> stored_;
  std::vector<LoopMessage> loops_that_are_known_;
  std::vector<nav_msgs::Odometry> fixes_that_are_known_;
  std::uint32_t searched_ = 0;
  std::size_t requests_ = 0;
  ros::ServiceServer service_;
  Listener<LoopMessage> loops_{"loop"};
  Listener<LoopVerdictMessage> verdicts_{"loop_verdict"};
};

TEST_F(LoopClosingNode, FindsTheLoopsOfADriveThatItNeverHeardOf) {
  NodeProcess node("loop_closing_node", arguments_);
  ASSERT_TRUE(loops_.wait_for(1)) << node.output();
  const LoopMessage& loop = loops_.messages.front();
  EXPECT_EQ(loop.run_id, "run");
  EXPECT_LT(loop.from, loop.to);
  EXPECT_EQ(loop.header.stamp, stored_[loop.to].header.stamp);
  const Pose T_from_to = ros_border::from_message(loop).T_from_to;
  const Pose truth = straight(static_cast<int>(loop.from), 0.8).inverse() *
                     straight(kCount - 1 - static_cast<int>(loop.to), 0.8);
  EXPECT_TRUE(test::near(T_from_to.translation, truth.translation, 0.2));
  EXPECT_TRUE(verdicts_.wait_for(1));
  EXPECT_GT(loop.fitness, 0.0);
  char fitness[32];
  std::snprintf(fitness, sizeof fitness, "fitness %.2g m^2", loop.fitness);
  node.stop();  // what it says is complete only then
  EXPECT_TRUE(node.says(fitness)) << fitness << "\n" << node.output();
}

TEST_F(LoopClosingNode, SaysWhichMethodDoesTheWorkOfAnother) {
  std::vector<std::string> arguments = arguments_;
  arguments.emplace_back("_registration_method:=GICP_OMP");
  NodeProcess node("loop_closing_node", arguments);
  ASSERT_TRUE(wait_until([&] { return loops_.connected() && verdicts_.connected(); }));
  node.stop();
  EXPECT_TRUE(node.says("registration_method GICP_OMP is hdl_graph_slam's")) << node.output();
}

TEST_F(LoopClosingNode, GoesOnAfterItWasKilled) {
  auto node = std::make_unique<NodeProcess>("loop_closing_node", arguments_);
  ASSERT_TRUE(wait_until([&] { return requests_ > 2; }));
  node->kill();
  loops_.messages.clear();
  node = std::make_unique<NodeProcess>("loop_closing_node", arguments_);
  EXPECT_TRUE(loops_.wait_for(1)) << node->output();
}

/// The old key frames are there again, without another search for what was found before.
TEST_F(LoopClosingNode, GoesOnAtTheKeyFrameAtWhichItWasKilled) {
  searched_ = kCount - 5;
  Loop known;
  known.from = 19;
  known.to = 40;
  known.stamp = key_frame_at(40).stamp;
  known.covariance = diagonal_covariance(0.02, 0.002);
  loops_that_are_known_.push_back(ros_border::to_message(known, "run", "base_link"));
  NodeProcess node("loop_closing_node", arguments_);
  ASSERT_TRUE(verdicts_.wait_for(1) && loops_.wait_for(1)) << node.output();
  for (const auto& verdict : verdicts_.messages) EXPECT_GE(verdict.to, searched_);
  for (const auto& loop : loops_.messages) EXPECT_GE(loop.to, searched_);
}

TEST_F(LoopClosingNode, TakesLiveKeyFramesAndFetchesTheOnesThatWereLost) {
  std::vector<KeyFrameMessage> all;
  std::swap(all, stored_);
  NodeProcess node("loop_closing_node", arguments_);
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  for (const KeyFrameMessage& message : all) {
    stored_.push_back(message);
    if (message.index % 3 != 1) live.publish(message);
    ros::spinOnce();
  }
  ASSERT_TRUE(loops_.wait_for(1)) << node.output();
  EXPECT_GT(requests_, 1U);
}

/// GNSS of a point of the drive in East-North-Up axes that begin `east` metres from the map's.
nav_msgs::Odometry fix_at(int index, double east) {
  nav_msgs::Odometry message;
  message.header.stamp = ros_border::to_ros(key_frame_at(index).stamp);
  message.header.frame_id = "map";
  message.child_frame_id = "base_link";
  message.pose.pose = ros_border::to_message(true_pose(index));
  message.pose.pose.position.x -= east;
  message.pose.covariance[0] = message.pose.covariance[7] = message.pose.covariance[14] = 0.01;
  message.pose.covariance[21] = -1.0;  // the orientation is not known
  return message;
}

/// The loops to a resumed session were refused, as its positions seemed to be elsewhere.
TEST_F(LoopClosingNode, ComparesTheGnssOfASecondDriveInTheAxesOfTheSession) {
  constexpr double kEast = 70.0;  // m, of the first fix of the second drive
  const double kDegrees = kEast / 6391000.0 / std::cos(49.0 * M_PI / 180.0) * 180.0 / M_PI;
  std::vector<KeyFrameMessage> all;
  std::swap(all, stored_);
  for (int i = 0; i < kCount / 2; ++i) {
    stored_.push_back(all[i]);
    fixes_that_are_known_.push_back(fix_at(i, 0.0));
  }
  searched_ = kCount / 2;
  ros::param::set("/run_state/session_datum", "49 8.4 115 run");
  NodeProcess node("loop_closing_node", arguments_);
  const auto data = connected_publisher<sensor_msgs::NavSatFix>("gnss_datum");
  const auto fixes = connected_publisher<nav_msgs::Odometry>("synced_gnss");
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  sensor_msgs::NavSatFix datum;
  datum.latitude = 49.0;
  datum.longitude = 8.4 + kDegrees;
  datum.altitude = 115.0;
  data.publish(datum);
  for (int i = kCount / 2; i < kCount; ++i) fixes.publish(fix_at(i, kEast));
  ASSERT_TRUE(wait_until([&] { return requests_ > 1; })) << node.output();
  for (int i = kCount / 2; i < kCount; ++i) {
    all[i].segment = 1;
    live.publish(all[i]);
  }
  ASSERT_TRUE(loops_.wait_for(1)) << node.output();
  EXPECT_LT(loops_.messages.front().from, searched_);
  EXPECT_GE(loops_.messages.front().to, searched_);
  ros::param::del("/run_state");
}

TEST_F(LoopClosingNode, LivesOnAfterAMessageThatCannotBe) {
  NodeProcess node("loop_closing_node", arguments_);
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  KeyFrameMessage wrong = stored_.back();
  wrong.index = kCount;
  wrong.motion_covariance[0] = std::numeric_limits<double>::quiet_NaN();
  live.publish(wrong);
  EXPECT_TRUE(loops_.wait_for(1)) << node.output();
  EXPECT_TRUE(wait_until([&] { return node.says("covariance is not finite"); }));
}

}  // namespace
}  // namespace lidar_mapping::test
