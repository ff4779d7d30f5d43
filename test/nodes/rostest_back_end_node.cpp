// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "back_end_fixture.hpp"
#include "figures.hpp"
#include "near.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;

// The answer comes when the work is done, with figures.
TEST_F(BackEndNode, ClosesTheLoopAndAnswersWithFigures) {
  const auto node = start();
  publish(0, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  loops_.publish(round_loop());
  ASSERT_TRUE(poses_.wait_for(1)) << "an accepted loop is solved at once: " << node->output();
  EXPECT_FALSE(poses_.messages.back().thorough);
  const OptimizeMap::Response answer = optimize();
  EXPECT_TRUE(answer.success) << answer.message;
  EXPECT_EQ(answer.key_frames, static_cast<std::uint32_t>(kRound));
  EXPECT_EQ(answer.loops_used, 1U);
  EXPECT_NE(answer.message.find("Loops: 1 used, 0 refused"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find("/save_map"), std::string::npos) << answer.message;
  EXPECT_GT(answer.corrected_largest, 0.2) << "odometry alone does not come back to its start";
  EXPECT_GT(answer.corrected_farthest, 0U);
  EXPECT_EQ(answer.session, sessions().front().string());
  EXPECT_TRUE(wait_until([&] { return poses_.messages.back().thorough; }));
  const KeyFramePoses poses = ros_border::from_message(known().poses);
  ASSERT_EQ(poses.poses.size(), static_cast<std::size_t>(kRound));
  EXPECT_TRUE(test::near(poses.poses.back().T_map_base.translation, Eigen::Vector3d::Zero(), 0.1));
  EXPECT_EQ(poses.poses.back().stamp, round_key_frame(kRound - 1).stamp);
  const fs::path trajectory = sessions().front() / "trajectory";
  for (const char* name : {"optimized.txt", "optimized.tum", "laser_odom.txt"}) {
    EXPECT_TRUE(fs::exists(trajectory / name)) << name;
  }
  node->stop();
  const std::string end = sessions().front().string() + ": " + std::to_string(kRound);
  EXPECT_TRUE(node->says("session " + end + " key frames")) << node->output();
}

std::vector<std::uint32_t> counted(int begin, int end) {
  std::vector<std::uint32_t> result;
  for (int i = begin; i < end; ++i) result.push_back(static_cast<std::uint32_t>(i));
  return result;
}

/// A second round is driven. Its loops leave the first one, and what leads to them, where they are.
TEST_F(BackEndNode, SendsThePosesThatMovedAndAllToWhoComesLate) {
  const auto node = start();
  publish(0, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  loops_.publish(round_loop());
  ASSERT_TRUE(poses_.wait_for(1)) << node->output();
  publish(kRound, kRound + 25);
  ASSERT_TRUE(wait_for_key_frames(kRound + 25)) << node->output();
  loops_.publish(round_loop(kRound + 10, kRound + 24));
  ASSERT_TRUE(poses_.wait_for(2)) << node->output();
  publish(kRound + 25, kRound + 30);
  ASSERT_TRUE(wait_for_key_frames(kRound + 30)) << node->output();
  loops_.publish(round_loop(kRound + 5, kRound + 24));
  ASSERT_TRUE(poses_.wait_for(3)) << node->output();

  const std::vector<KeyFramePosesMessage> sent = poses_.messages;
  EXPECT_TRUE(sent[0].whole);
  EXPECT_EQ(sent[0].indices, counted(0, kRound));
  EXPECT_FALSE(sent[1].whole);
  EXPECT_EQ(sent[1].since, sent[0].revision);
  EXPECT_EQ(sent[1].indices, counted(kRound, kRound + 25)) << "the new ones";
  EXPECT_FALSE(sent[2].whole);
  EXPECT_EQ(sent[2].since, sent[1].revision);
  EXPECT_EQ(sent[2].indices, counted(kRound + 6, kRound + 30)) << "the new and the moved ones";

  poses_.subscribe_again();
  ASSERT_TRUE(poses_.wait_for(1)) << node->output();
  EXPECT_TRUE(poses_.messages[0].whole);
  EXPECT_EQ(poses_.messages[0].revision, sent[2].revision);
  EXPECT_EQ(poses_.messages[0].indices, counted(0, kRound + 30));
  const KeyFramePoses late = ros_border::from_message(poses_.messages[0]);
  const KeyFramePoses exact = ros_border::from_message(known().poses);
  ASSERT_EQ(exact.poses.size(), late.poses.size());
  for (std::size_t i = 0; i < late.poses.size(); ++i) {
    EXPECT_TRUE(test::near(late.poses[i].T_map_base, exact.poses[i].T_map_base, 0.001)) << i;
  }
}

/// What a person asked for is exact.
TEST_F(BackEndNode, SendsAllPosesAsTheAnswerToOptimizeMap) {
  const auto node = start();
  publish(0, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  for (std::size_t i = 1; i <= 2; ++i) {
    EXPECT_TRUE(optimize().success);
    ASSERT_TRUE(poses_.wait_for(i)) << node->output();
    EXPECT_TRUE(poses_.messages.back().thorough);
    EXPECT_TRUE(poses_.messages.back().whole) << "also where nothing moved";
    EXPECT_EQ(poses_.messages.back().indices, counted(0, kRound));
  }
}

/// Without loops and GNSS nothing is optimised unasked; the node is at work all the same.
TEST_F(BackEndNode, SaysThatItMapsADriveOfTheLidarAlone) {
  Diagnostics diagnostics("/diagnostics");
  const auto node = start();
  publish(0, 5);
  ASSERT_TRUE(wait_for_key_frames(5));
  EXPECT_TRUE(wait_until([&] {
    return !diagnostics.messages.empty() &&
           diagnostics.messages.back().status.at(0).message == "mapping";
  })) << diagnostics.messages.back().status.at(0).message;
}

// An empty graph says so.
TEST_F(BackEndNode, SaysThatThereIsNothingToOptimise) {
  const auto node = start();
  const OptimizeMap::Response answer = optimize();
  EXPECT_FALSE(answer.success);
  EXPECT_NE(answer.message.find("no key frames"), std::string::npos) << answer.message;
}

// Clouds come over the service, those that were asked for.
TEST_F(BackEndNode, GivesKeyFramesWithAndWithoutClouds) {
  const auto node = start();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10));
  EXPECT_EQ(known().key_frames[3].cloud.width, 0U);
  const GetKeyFrames::Response answer = known(true, {3, 7, 99});
  ASSERT_EQ(answer.key_frames.size(), 2U);
  const KeyFrame key_frame = ros_border::from_message(answer.key_frames[1]);
  const KeyFrame expected = round_key_frame(7);
  EXPECT_EQ(key_frame.index, 7U);
  EXPECT_EQ(key_frame.stamp, expected.stamp);
  ASSERT_NE(key_frame.cloud, nullptr);
  EXPECT_EQ(key_frame.cloud->size(), expected.cloud->size());
  EXPECT_TRUE(test::near(key_frame.T_odom_base, expected.T_odom_base, 1e-9));
}

/// What a loop_closing_node that starts again goes on with.
TEST_F(BackEndNode, GivesLoopsAndPositionsOfKeyFrames) {
  const auto node = start();
  const auto gnss = connected_publisher<nav_msgs::Odometry>("synced_gnss");
  const auto verdicts = connected_publisher<LoopVerdictMessage>("loop_verdict");
  publish(0, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound));
  loops_.publish(round_loop());
  loops_.publish(round_loop());
  loops_.publish(round_loop(0, kRound - 2));
  nav_msgs::Odometry fix;
  fix.child_frame_id = "base_link";
  fix.pose.pose.orientation.w = 1.0;
  fix.pose.covariance[0] = fix.pose.covariance[7] = fix.pose.covariance[14] = 1.0;
  for (const Stamp after_key_frame : {0, 1}) {
    fix.header.stamp = ros_border::to_ros(round_key_frame(3).stamp + after_key_frame);
    gnss.publish(fix);
  }
  const auto floors = connected_publisher<FloorMessage>("floor");
  Floor floor;
  for (const int i : {3, 4}) {
    floor.stamp = round_key_frame(i).stamp;
    floor.found = i == 3;
    floors.publish(ros_border::to_message(floor, "base_link"));
  }
  EXPECT_TRUE(wait_until([&] { return known().floors.size() == 1; }));
  LoopVerdict verdict;
  for (const KeyFrameIndex to : {20U, 30U, 25U}) {
    verdict.to = to;
    const bool waits = to == 25U;
    verdict.verdict = waits ? Verdict::kUndecided : Verdict::kRefused;
    verdict.reason = waits ? waiting_reason(30.0) : "for the test";
    verdicts.publish(ros_border::to_message(verdict, "run", "base_link"));
  }
  EXPECT_TRUE(wait_until([&] { return known().searched == 25; })) << "25 is open yet";
  verdict.verdict = Verdict::kAccepted;
  verdicts.publish(ros_border::to_message(verdict, "run", "base_link"));
  GetKeyFrames::Response answer;
  ASSERT_TRUE(wait_until([&] {
    answer = known();
    return answer.searched > 30 && answer.gnss.size() == 1 && !answer.loops.empty() &&
           answer.loops.back().to == kRound - 2;
  }));
  EXPECT_EQ(answer.loops.size(), 2U) << "one came twice";
  EXPECT_EQ(ros_border::from_ros(answer.gnss[0].header.stamp), round_key_frame(3).stamp);
  EXPECT_EQ(answer.antennas.size(), 1U);
}

// Unknown, equal and foreign indices are refused with a message, and nothing ends.
TEST_F(BackEndNode, RefusesLoopsThatDoNotFit) {
  const auto node = start();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10));
  loops_.publish(round_loop(0, kRound - 1));
  loops_.publish(round_loop(4, 4));
  loops_.publish(round_loop(0, 9, "another run"));
  EXPECT_TRUE(wait_until([&] { return node->says("does not fit the graph"); }));
  EXPECT_EQ(optimize().loops_used + optimize().loops_refused, 0U);
  EXPECT_TRUE(node->is_running());
}

/// As front_end_node and loop_closing_node give them to a back end that starts in mid-drive.
TEST_F(BackEndNode, PutsInOrderWhatComesAgainAndEarly) {
  const auto node = start();
  loops_.publish(round_loop());
  publish(0, 10);
  publish(12, 15);
  publish(5, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  loops_.publish(round_loop());
  EXPECT_TRUE(wait_until([&] { return optimize().loops_used == 1; })) << node->output();
  const KeyFramePoses poses = ros_border::from_message(known().poses);
  for (std::size_t i = 0; i < poses.poses.size(); ++i) EXPECT_EQ(poses.poses[i].index, i);
}

TEST_F(BackEndNode, GivesUpAKeyFrameThatNeverComes) {
  const auto node = start();
  publish(0, 10);
  publish(11, 13);
  EXPECT_TRUE(wait_until([&] { return optimize().key_frames == 12; })) << node->output();
  EXPECT_TRUE(node->says("key frames that did not arrive: 1")) << node->output();
}

TEST_F(BackEndNode, SaysThatItDropsLoopsWhoseKeyFramesDoNotCome) {
  const auto node = start();
  EXPECT_TRUE(wait_until([&] {
    for (int i = 0; i < 50; ++i) loops_.publish(round_loop());
    return node->says("loops that came before their key frames: too many wait");
  })) << node->output();
}

/// As a back end does that starts in mid-drive.
TEST_F(BackEndNode, KeepsVerdictsThatComeBeforeTheFirstKeyFrame) {
  Diagnostics diagnostics("/diagnostics");
  const auto node = start();
  const auto verdicts = connected_publisher<LoopVerdictMessage>("loop_verdict");
  LoopVerdict verdict;
  verdict.verdict = Verdict::kRefused;
  for (const char* run_id : {"run", "another run"}) {
    verdict.to += 7;
    verdicts.publish(ros_border::to_message(verdict, run_id, "base_link"));
  }
  ASSERT_TRUE(reports(diagnostics, "queue loop_verdict", ".* 2 handled.*")) << node->output();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10)) << node->output();
  EXPECT_EQ(known().searched, 8U);
  EXPECT_TRUE(reports(diagnostics, "verdicts of other runs", "1"));
}

/// While the drive goes on nothing waits for long.
TEST_F(BackEndNode, SaysThatItGivesUpAKeyFrameInMidDrive) {
  const auto node = start();
  publish(0, 10);
  publish(11, 18);
  EXPECT_TRUE(wait_for_key_frames(17)) << node->output();
  EXPECT_TRUE(wait_until([&] { return node->says("key frames that did not arrive: 1"); }))
      << node->output();
}

nav_msgs::Odometry odometry_at(Stamp stamp, const Pose& T_odom_base) {
  nav_msgs::Odometry message;
  message.header.frame_id = "odom";
  message.header.stamp = ros_border::to_ros(stamp);
  message.child_frame_id = "base_link";
  message.pose.pose = ros_border::to_message(T_odom_base);
  return message;
}

// Tf map -> odom at the stamps of the data, never twice for one.
TEST_F(BackEndNode, BroadcastsMapToOdomAtTheStampsOfOdometry) {
  Listener<tf2_msgs::TFMessage> transforms("/tf");
  Listener<nav_msgs::Odometry> optimized("optimized_odom");
  const auto node = start();
  const auto odometry = connected_publisher<nav_msgs::Odometry>("laser_odom");
  ASSERT_TRUE(wait_until([&] { return transforms.connected() && optimized.connected(); }));
  for (const int i : {1, 2, 2, 3}) {
    odometry.publish(odometry_at(round_key_frame(i).stamp, Pose::Identity()));
  }
  ASSERT_TRUE(optimized.wait_for(4)) << node->output();
  ASSERT_TRUE(transforms.wait_for(3));
  EXPECT_EQ(transforms.messages.size(), 3U);
  const auto& first = transforms.messages[0].transforms[0];
  EXPECT_EQ(first.header.frame_id, "map");
  EXPECT_EQ(first.child_frame_id, "odom");
  EXPECT_EQ(ros_border::from_ros(first.header.stamp), round_key_frame(1).stamp);
  EXPECT_EQ(optimized.messages[0].header.frame_id, "map");
}

TEST_F(BackEndNode, UsesTheNamesOfFramesThatItIsGiven) {
  Listener<tf2_msgs::TFMessage> transforms("/tf");
  Listener<nav_msgs::Odometry> optimized("optimized_odom");
  const auto node = start({"_map_frame:=world", "_odom_frame:=track", "_base_frame:=car"});
  const auto odometry = connected_publisher<nav_msgs::Odometry>("laser_odom");
  ASSERT_TRUE(wait_until([&] { return transforms.connected() && optimized.connected(); }));
  publish(0, 3);
  ASSERT_TRUE(wait_for_key_frames(3)) << node->output();
  optimize();
  nav_msgs::Odometry message = odometry_at(round_key_frame(2).stamp, Pose::Identity());
  message.header.frame_id = "track";
  message.child_frame_id = "car";
  odometry.publish(message);
  ASSERT_TRUE(optimized.wait_for(1) && transforms.wait_for(1) && poses_.wait_for(1));
  EXPECT_EQ(transforms.messages[0].transforms[0].header.frame_id, "world");
  EXPECT_EQ(transforms.messages[0].transforms[0].child_frame_id, "track");
  EXPECT_EQ(optimized.messages[0].header.frame_id, "world");
  EXPECT_EQ(optimized.messages[0].child_frame_id, "car");
  EXPECT_EQ(poses_.messages[0].header.frame_id, "world");
  EXPECT_EQ(known().key_frames.at(0).header.frame_id, "car");
}

/// What tf and optimized_odom are for: the odometry of the last key frame, moved to where the graph
/// has it. The correction also holds for the scans after it.
TEST_F(BackEndNode, CorrectsTheOdometryByWhatTheLoopSays) {
  Listener<tf2_msgs::TFMessage> transforms("/tf");
  Listener<nav_msgs::Odometry> optimized("optimized_odom");
  const auto node = start();
  const auto odometry = connected_publisher<nav_msgs::Odometry>("laser_odom");
  ASSERT_TRUE(wait_until([&] { return transforms.connected() && optimized.connected(); }));
  publish(0, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  loops_.publish(round_loop());
  ASSERT_TRUE(wait_until([&] { return optimize().loops_used == 1; })) << node->output();

  const KeyFrame last = round_key_frame(kRound - 1);
  const Pose T_map_base = ros_border::from_message(known().poses).poses.back().T_map_base;
  const Pose T_map_odom = T_map_base * last.T_odom_base.inverse();
  ASSERT_GT((T_map_base.translation - last.T_odom_base.translation).norm(), 0.3)
      << "the odometry has to be wrong, or nothing is corrected";
  const Pose ahead{exp_so3({0.0, 0.0, 0.1}), {1.5, 0.2, 0.0}};
  nav_msgs::Odometry message = odometry_at(last.stamp, last.T_odom_base);
  message.pose.covariance[0] = 4.0;
  message.pose.covariance[7] = 1.0;
  odometry.publish(message);
  message.header.stamp = ros_border::to_ros(last.stamp + 100000000);
  message.pose.pose = ros_border::to_message(last.T_odom_base * ahead);
  odometry.publish(message);
  ASSERT_TRUE(optimized.wait_for(2) && transforms.wait_for(2)) << node->output();
  const auto pose_of = [&](std::size_t i) {
    return ros_border::from_message(optimized.messages[i].pose.pose);
  };
  EXPECT_TRUE(test::near(pose_of(0), T_map_base, 1e-6));
  EXPECT_TRUE(test::near(pose_of(1), T_map_base * ahead, 1e-6));
  EXPECT_EQ(optimized.messages[0].header.frame_id, "map");
  EXPECT_EQ(optimized.messages[0].child_frame_id, "base_link");
  EXPECT_EQ(ros_border::from_ros(optimized.messages[0].header.stamp), last.stamp);
  const Eigen::Matrix3d R = T_map_odom.rotation_matrix();
  const Eigen::Matrix3d turned = R * Eigen::Vector3d(4.0, 1.0, 0.0).asDiagonal() * R.transpose();
  EXPECT_NEAR(optimized.messages[0].pose.covariance[1], turned(0, 1), 1e-9);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& transform = transforms.messages[i].transforms.at(0);
    EXPECT_EQ(transform.header.frame_id, "map");
    EXPECT_EQ(transform.child_frame_id, "odom");
    EXPECT_TRUE(test::near(ros_border::from_message(transform.transform), T_map_odom, 1e-6));
  }
}

}  // namespace
}  // namespace lidar_mapping::test
