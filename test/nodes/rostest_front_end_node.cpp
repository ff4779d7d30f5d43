// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/UInt32.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"

#include "listener.hpp"
#include "node_process.hpp"
#include "temporary_folder.hpp"
#include "yard.hpp"

namespace lidar_mapping::test {
namespace {

using ros_border::from_ros;

/// A front end with listeners on all that it says.
class FrontEndNode : public testing::Test {
 protected:
  FrontEndNode() { start({}); }

  void start(std::vector<std::string> arguments) {
    arguments.push_back("_key_frame_distance:=1.9");
    node_.reset();
    // The links to the node before must be gone, or they would be taken for the new node's.
    clouds_ = ros::Publisher();
    ASSERT_TRUE(wait_until([&] { return listeners_connected() == 0; }));
    node_ = std::make_unique<NodeProcess>("front_end_node", arguments);
    clouds_ = connected_publisher<sensor_msgs::PointCloud2>("synced_cloud");
    ASSERT_TRUE(wait_until([&] { return listeners_connected() == 4; }));
  }
  int listeners_connected() const {
    return int{odometry_.connected()} + int{key_frames_.connected()} + int{status_.connected()} +
           int{tf_.connected()};
  }
  void send(int step) {
    clouds_.publish(
        ros_border::to_message(yard_seen_from(straight(step), 7U), stamp_of(step), "base_link"));
  }
  void drive(int from, int to) {
    for (int step = from; step < to; ++step) {
      const std::size_t before = odometry_.messages.size();
      send(step);
      wait_until([&] { return odometry_.messages.size() > before; }, 2.0);
    }
  }

  std::unique_ptr<NodeProcess> node_;
  ros::Publisher clouds_;
  Listener<nav_msgs::Odometry> odometry_{"laser_odom"};
  Listener<KeyFrameMessage> key_frames_{"key_frame"};
  Listener<FrontEndStatusMessage> status_{"front_end_status"};
  Listener<tf2_msgs::TFMessage> tf_{"tf"};
};

// Stamps were mangled, and lost messages shifted the pairs.
TEST_F(FrontEndNode, GivesOdometryForEachScanWithItsStampBitForBit) {
  drive(0, 12);
  ASSERT_TRUE(odometry_.wait_for(12));
  for (int step = 0; step < 12; ++step) {
    const nav_msgs::Odometry& message = odometry_.messages[step];
    EXPECT_EQ(from_ros(message.header.stamp), stamp_of(step));
    EXPECT_EQ(message.header.frame_id, "odom");
    EXPECT_EQ(message.child_frame_id, "base_link");
    EXPECT_NEAR(message.pose.pose.position.x, 0.5 * step, 0.1);
  }
  ASSERT_TRUE(status_.wait_for(12));
  EXPECT_EQ(from_ros(status_.messages[5].header.stamp), stamp_of(5));
  EXPECT_EQ(status_.messages[5].state, "tracking");
}

/// A scan that never reached preprocessing is not in the map either.
TEST_F(FrontEndNode, CountsTheScansThatWereLostBeforeIt) {
  const auto lost = connected_publisher<std_msgs::UInt32>("scans_lost");
  std_msgs::UInt32 six;
  six.data = 6;
  lost.publish(six);
  int step = 0;
  EXPECT_TRUE(wait_until([&] {
    drive(step, step + 1);
    ++step;
    return !status_.messages.empty() && status_.messages.back().scans_dropped == 6;
  }));
}

// No covariance, no twist, no tf.
TEST_F(FrontEndNode, GivesCovarianceTwistAndTransform) {
  drive(0, 12);
  ASSERT_TRUE(odometry_.wait_for(12));
  const nav_msgs::Odometry& last = odometry_.messages.back();
  EXPECT_NEAR(last.twist.twist.linear.x, 5.0, 0.5);
  EXPECT_GT(last.pose.covariance[0], 0.0);
  EXPECT_GT(last.twist.covariance[0], 0.0);
  ASSERT_TRUE(tf_.wait_for(12));
  const auto& transform = tf_.messages.back().transforms.at(0);
  EXPECT_EQ(transform.header.frame_id, "odom");
  EXPECT_EQ(transform.child_frame_id, "base_link");
  EXPECT_EQ(from_ros(transform.header.stamp), stamp_of(11));
  EXPECT_EQ(transform.transform.translation.x, last.pose.pose.position.x);
}

// A stored cloud must have the pose of its own stamp.
TEST_F(FrontEndNode, NumbersItsKeyFramesAndGivesThemThePoseOfTheirStamp) {
  drive(0, 14);
  ASSERT_TRUE(odometry_.wait_for(14) && key_frames_.wait_for(3));
  for (std::size_t i = 0; i < key_frames_.messages.size(); ++i) {
    const KeyFrameMessage& key_frame = key_frames_.messages[i];
    EXPECT_EQ(key_frame.index, i);
    EXPECT_EQ(key_frame.segment, 0U);
    EXPECT_FALSE(key_frame.run_id.empty());
    EXPECT_EQ(key_frame.header.frame_id, "base_link");
    EXPECT_EQ(key_frame.cloud.header.stamp, key_frame.header.stamp);
    EXPECT_GT(key_frame.cloud.width, 1000U);
    const auto odometry = std::find_if(
        odometry_.messages.begin(), odometry_.messages.end(),
        [&](const auto& message) { return message.header.stamp == key_frame.header.stamp; });
    ASSERT_NE(odometry, odometry_.messages.end());
    EXPECT_EQ(key_frame.odometry_pose.position.x, odometry->pose.pose.position.x);
  }
}

// Empty and all-NaN sweeps crashed, or became key frames.
TEST_F(FrontEndNode, LeavesOutScansThatCannotBeUsedAndSaysWhy) {
  drive(0, 3);
  clouds_.publish(ros_border::to_message(PointCloud(), stamp_of(3), "base_link"));
  PointCloud not_finite = yard_seen_from(straight(3), 7U);
  for (Point& point : not_finite.points) point.x = std::numeric_limits<float>::quiet_NaN();
  clouds_.publish(ros_border::to_message(not_finite, stamp_of(4), "base_link"));
  clouds_.publish(
      ros_border::to_message(yard_seen_from(straight(1), 7U), stamp_of(1), "base_link"));
  drive(5, 8);
  ASSERT_TRUE(odometry_.wait_for(6));
  EXPECT_EQ(odometry_.messages.size(), 6U);
  EXPECT_NEAR(odometry_.messages.back().pose.pose.position.x, 3.5, 0.2);
  EXPECT_TRUE(node_->says("no point with finite coordinates")) << node_->output();
  EXPECT_TRUE(node_->says("stamp of a scan goes back by 0.1")) << node_->output();
}

TEST_F(FrontEndNode, SaysOnceThatABagIsPlayedAgain) {
  drive(0, 12);
  ASSERT_TRUE(odometry_.wait_for(12));
  for (int step = 0; step < 5; ++step) send(step);
  drive(12, 13);
  ASSERT_TRUE(odometry_.wait_for(13));
  EXPECT_EQ(from_ros(odometry_.messages.back().header.stamp), stamp_of(12));
  EXPECT_TRUE(node_->says("time went back: the nodes map one drive per start")) << node_->output();
  EXPECT_EQ(node_->count("time went back"), 1U) << node_->output();
  EXPECT_FALSE(node_->says("message left out")) << node_->output();
}

// Queues without bound, and losses in silence.
TEST_F(FrontEndNode, CountsEveryScanThatItCannotKeepUpWith) {
  start({"_queue_size:=3"});
  odometry_.messages.clear();
  status_.messages.clear();
  for (int step = 0; step < 40; ++step) send(step);
  const auto accounted = [&] {
    return status_.messages.empty()
               ? 0
               : status_.messages.size() + status_.messages.back().scans_dropped;
  };
  EXPECT_TRUE(wait_until([&] { return accounted() == 40; }))
      << status_.messages.size() << " scans handled, " << accounted() << " accounted for";
  EXPECT_TRUE(odometry_.wait_for(status_.messages.size()));
  EXPECT_EQ(odometry_.messages.size(), status_.messages.size());
}

// A missing transform killed or muted the pipeline.
// Not before a second has passed: /tf_static may come a moment after the first scan.
TEST_F(FrontEndNode, NamesBothFramesOfAMissingTransformOnceAndLivesOn) {
  const std::string warning = "no transform from frame 'velodyne' to 'base_link' yet";
  const ros::WallTime begin = ros::WallTime::now();
  const auto seconds = [&] { return (ros::WallTime::now() - begin).toSec(); };
  int step = 0;
  const auto send_scan_of_no_known_frame = [&] {
    clouds_.publish(
        ros_border::to_message(yard_seen_from(straight(step), 7U), stamp_of(step), "/velodyne"));
    ++step;
  };
  for (int i = 0; i < 4; ++i) send_scan_of_no_known_frame();
  const bool is_said = node_->says(warning);
  // On a busy machine the second may be over here.
  EXPECT_TRUE(seconds() >= 1.0 || !is_said) << node_->output();
  ASSERT_TRUE(send_until(send_scan_of_no_known_frame, [&] { return node_->says(warning); }))
      << node_->output();
  drive(step, step + 2);
  ASSERT_TRUE(odometry_.wait_for(1));
  EXPECT_EQ(from_ros(odometry_.messages.front().header.stamp), stamp_of(step));
  EXPECT_LE(node_->count(warning), 1U + static_cast<std::size_t>(seconds() / 5.0))
      << "once in 5 s: " << node_->output();
}

TEST_F(FrontEndNode, TakesTheMotionFromOutsideWhenToldTo) {
  start({"_odometry:=external"});
  const auto outside = connected_publisher<nav_msgs::Odometry>("external_odom");
  for (int step = 0; step < 12; ++step) {
    nav_msgs::Odometry message;
    message.header.stamp = ros_border::to_ros(stamp_of(step));
    message.pose.pose =
        ros_border::to_message(Pose{Eigen::Quaterniond::Identity(), {0.8 * step, 0.1 * step, 0.0}});
    outside.publish(message);
    send(step);
  }
  ASSERT_TRUE(odometry_.wait_for(12));
  EXPECT_NEAR(odometry_.messages.back().pose.pose.position.y -
                  odometry_.messages.front().pose.pose.position.y,
              1.1, 1e-6);
  EXPECT_TRUE(key_frames_.wait_for(3));
}

/// As rviz's "2D Pose Estimate" gives it.
TEST_F(FrontEndNode, BeginsAtTheInitialPoseAndSaysWhenItComesTooLate) {
  const auto initial = connected_publisher<geometry_msgs::PoseWithCovarianceStamped>("initialpose");
  ASSERT_TRUE(wait_until([] { return is_connected("initialpose"); }));
  const auto publish = [&](const std::string& frame) {
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.frame_id = frame;
    message.pose.pose = ros_border::to_message(Pose{exp_so3({0.0, 0.0, 0.5 * M_PI}), {20, 30, 1}});
    initial.publish(message);
  };
  publish("map");
  publish("elsewhere");  // one after the other: when this is refused that is taken
  ASSERT_TRUE(wait_until([&] { return node_->says("the initial pose is in frame 'elsewhere'"); }))
      << node_->output();
  drive(0, 8);
  ASSERT_TRUE(odometry_.wait_for(8));
  EXPECT_NEAR(odometry_.messages.back().pose.pose.position.x, 20.0, 0.2);
  EXPECT_NEAR(odometry_.messages.back().pose.pose.position.y, 33.5, 0.3);
  EXPECT_NEAR(odometry_.messages.back().pose.pose.position.z, 1.0, 0.1);
  // Warnings of one topic come at most once in 5 s.
  EXPECT_TRUE(
      send_until([&] { publish("map"); },
                 [&] { return node_->says("the initial pose comes after the first scan"); }))
      << node_->output();
}

/// Points all around in which nothing is ever found again.
PointCloud chaos(int step) {
  std::mt19937 random(static_cast<unsigned>(step));
  std::normal_distribution<float> axis(0.0F, 15.0F);
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i) cloud.points.push_back({axis(random), axis(random), axis(random)});
  return cloud;
}

/// Localisation took the step into a new segment for a measured one, by its covariance.
TEST_F(FrontEndNode, StatesNoCovarianceOfTheStepIntoANewSegment) {
  start({"_max_lost_time:=0.25"});
  odometry_.messages.clear();
  key_frames_.messages.clear();
  drive(0, 12);
  for (int step = 12; step < 18; ++step) {
    clouds_.publish(ros_border::to_message(chaos(step), stamp_of(step), "base_link"));
    ASSERT_TRUE(odometry_.wait_for(static_cast<std::size_t>(step) + 1)) << node_->output();
  }
  drive(18, 24);
  ASSERT_TRUE(wait_until([&] {
    return !key_frames_.messages.empty() && key_frames_.messages.back().segment > 0;
  })) << node_->output();
  std::vector<int> without_covariance;
  for (std::size_t step = 0; step < odometry_.messages.size(); ++step) {
    const nav_msgs::Odometry& message = odometry_.messages[step];
    if (message.twist.covariance[0] == 0.0) without_covariance.push_back(static_cast<int>(step));
  }
  ASSERT_GE(without_covariance.size(), 2U);
  EXPECT_EQ(without_covariance[0], 0);
  EXPECT_GT(without_covariance[1], 11) << "all motions in the yard are measured";
  EXPECT_LE(without_covariance.back(), 18);
}

/// A back end that starts in mid-drive must not lack what was sent before it was connected.
TEST_F(FrontEndNode, GivesItsKeyFramesAgainToWhoComesLate) {
  drive(0, 14);
  ASSERT_TRUE(key_frames_.wait_for(3));
  const TemporaryFolder folder;
  const NodeProcess late("back_end_node", {"_session_directory:=" + folder.path().string()});
  GetKeyFrames known;
  EXPECT_TRUE(wait_until([&] {
    return ros::service::exists("get_key_frames", false) &&
           ros::service::call("get_key_frames", known) &&
           known.response.key_frames.size() == key_frames_.messages.size();
  })) << late.output();
}

/// A back end with a run whose last key frame, number 41, has this stamp.
ros::ServiceServer back_end_with_run_until(Stamp stamp) {
  const boost::function<bool(GetKeyFrames::Request&, GetKeyFrames::Response&)> answer =
      [stamp](GetKeyFrames::Request&, GetKeyFrames::Response& response) {
        KeyFrame last;
        last.stamp = stamp;
        last.index = 41;
        last.segment = 2;
        last.T_odom_base.translation.x() = 100.0;
        response.key_frames.push_back(ros_border::to_message(last, "the run", "base_link"));
        response.poses.run_id = "the run";
        return true;
      };
  return ros::NodeHandle().advertiseService("get_key_frames", answer);
}

TEST_F(FrontEndNode, GoesOnWithTheRunThatTheBackEndHas) {
  const ros::ServiceServer service = back_end_with_run_until(stamp_of(-10));
  drive(0, 3);
  ASSERT_TRUE(key_frames_.wait_for(1));
  EXPECT_EQ(key_frames_.messages.front().run_id, "the run");
  EXPECT_EQ(key_frames_.messages.front().index, 42U);
  EXPECT_EQ(key_frames_.messages.front().segment, 3U);
  EXPECT_NEAR(key_frames_.messages.front().odometry_pose.position.x, 100.0, 1e-6);
}

/// The bag of the session itself was mapped again, into it.
TEST_F(FrontEndNode, LeavesOutScansThatAreNotLaterThanTheRunThatItGoesOnWith) {
  Listener<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  const ros::ServiceServer service = back_end_with_run_until(stamp_of(20));
  for (int step = 0; step <= 20; ++step) send(step);
  const std::string problem = "time went back: these scans are not later than the session";
  EXPECT_TRUE(wait_until([&] {
    return std::any_of(diagnostics.messages.begin(), diagnostics.messages.end(),
                       [&](const auto& message) {
                         const auto& status = message.status.at(0);
                         return status.level == diagnostic_msgs::DiagnosticStatus::ERROR &&
                                status.message.find(problem) == 0;
                       });
  })) << node_->output();
  drive(21, 23);
  ASSERT_TRUE(odometry_.wait_for(2) && key_frames_.wait_for(1)) << node_->output();
  EXPECT_EQ(from_ros(odometry_.messages.front().header.stamp), stamp_of(21));
  EXPECT_EQ(key_frames_.messages.front().index, 42U);
  EXPECT_EQ(node_->count(problem), 1U) << node_->output();
}

/// It began a run of its own, which ended the session that was asked for.
TEST_F(FrontEndNode, WaitsForTheSessionThatTheBackEndReads) {
  const TemporaryFolder folder;
  const std::vector<std::string> back_end = {"_session_directory:=" + folder.path().string()};
  auto before = std::make_unique<NodeProcess>("back_end_node", back_end);
  drive(0, 14);
  GetKeyFrames known;
  ASSERT_TRUE(key_frames_.wait_for(3) && wait_until([&] {
                return ros::service::exists("get_key_frames", false) &&
                       ros::service::call("get_key_frames", known) &&
                       known.response.key_frames.size() == key_frames_.messages.size();
              }))
      << before->output();
  before->stop();

  ros::param::set("/run_state/resuming", "back_end_node");  // as mapping.launch does
  start({});
  odometry_.messages.clear();
  key_frames_.messages.clear();
  int step = 14;
  while (step < 18) send(step++);
  EXPECT_FALSE(wait_until([&] { return !odometry_.messages.empty(); }, 3.0)) << node_->output();
  std::vector<std::string> resuming = back_end;
  resuming.emplace_back("_resume:=latest");
  const NodeProcess after("back_end_node", resuming);
  ASSERT_TRUE(send_until([&] { send(step++); }, [&] { return !key_frames_.messages.empty(); }))
      << node_->output() << after.output();
  EXPECT_EQ(key_frames_.messages.front().run_id, known.response.poses.run_id);
  EXPECT_EQ(key_frames_.messages.front().index, known.response.key_frames.size());
  EXPECT_EQ(from_ros(odometry_.messages.front().header.stamp), stamp_of(14));
  EXPECT_TRUE(wait_until([] { return !ros::param::has("/run_state/resuming"); }));
}

/// Extent of a cloud in a frame.
struct Extent {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F), high = Eigen::Vector3f::Constant(-1e9F);
};
Extent extent_of(const sensor_msgs::PointCloud2& message) {
  Extent extent;
  for (const Point& point : ros_border::from_message(message).points) {
    extent.low = extent.low.cwiseMin(point.position());
    extent.high = extent.high.cwiseMax(point.position());
  }
  return extent;
}

/// The yard reaches from x = -15 m to 35 m of its origin, from y = -12 m to 12 m; the drive begins
/// 1 m above its ground.
TEST_F(FrontEndNode, ShowsTheScanInTheVehiclesFrameAndTheLocalMapInThatOfTheOdometry) {
  Listener<sensor_msgs::PointCloud2> scans("current_scan");
  Listener<sensor_msgs::PointCloud2> maps("local_map");
  ASSERT_TRUE(wait_until([&] { return scans.connected() && maps.connected(); }));
  drive(0, 14);
  ASSERT_TRUE(odometry_.wait_for(14) && scans.wait_for(1) && maps.wait_for(1));
  ASSERT_TRUE(
      wait_until([&] { return from_ros(scans.messages.back().header.stamp) == stamp_of(13); }));
  EXPECT_EQ(scans.messages.back().header.frame_id, "base_link");
  EXPECT_TRUE(std::any_of(odometry_.messages.begin(), odometry_.messages.end(), [&](const auto& m) {
    return m.header.stamp == maps.messages.front().header.stamp;
  })) << "it has the stamp of a scan";
  EXPECT_EQ(maps.messages.back().header.frame_id, "odom");
  const double x = odometry_.messages.back().pose.pose.position.x;
  const double x0 = odometry_.messages.front().pose.pose.position.x;
  EXPECT_NEAR(x - x0, 6.5, 0.2);
  const Extent scan = extent_of(scans.messages.back());
  EXPECT_NEAR(scan.low.x(), -15.0 - 6.5, 0.3) << "from where the vehicle is now";
  EXPECT_NEAR(scan.high.x(), 35.0 - 6.5, 0.3);
  const Extent map = extent_of(maps.messages.back());
  EXPECT_NEAR(map.low.x(), -15.0, 1.5) << "from where the odometry began, to a voxel";
  EXPECT_NEAR(map.high.x(), 35.0, 1.5);
}

/// The yard as a sweep of 0.1 s before the stamp shows it at 5 m/s; the times have the wrong sign.
PointCloud sweep_with_wrong_times(int step) {
  PointCloud cloud = yard_seen_from(straight(step), 7U);
  for (Point& point : cloud.points) {
    const double turned = std::atan2(point.y, point.x) / (2.0 * M_PI) + 0.5;  // 0 to 1
    const auto time = static_cast<float>(0.1 * (turned - 1.0));
    point.x -= 5.0F * time;
    cloud.times.push_back(-time);
  }
  return cloud;
}

/// Whoever localises it needs the scan as the map will have it.
TEST_F(FrontEndNode, ShowsTheScanWithTheTimesThatItFoundRight) {
  Listener<sensor_msgs::PointCloud2> scans("current_scan");
  ASSERT_TRUE(wait_until([&] { return scans.connected(); }));
  int step = 0;
  const auto drive_one = [&] {
    clouds_.publish(ros_border::to_message(sweep_with_wrong_times(step), stamp_of(step),  //
                                           "base_link"));
    ++step;
    return odometry_.wait_for(static_cast<std::size_t>(step));
  };
  const auto is_corrected = [&] {
    return !status_.messages.empty() && status_.messages.back().sweep_times == "negated";
  };
  while (step < 50 && !is_corrected()) ASSERT_TRUE(drive_one()) << node_->output();
  ASSERT_TRUE(is_corrected()) << node_->output();
  ASSERT_TRUE(drive_one() && wait_until([&] {
                return from_ros(scans.messages.back().header.stamp) == stamp_of(step - 1);
              }));
  const Extent scan = extent_of(scans.messages.back());
  const auto x = static_cast<float>(straight(step - 1).translation.x());
  EXPECT_NEAR(scan.low.x(), -15.0F - x, 0.15F) << "both ends of the yard are seen as planes";
  EXPECT_NEAR(scan.high.x(), 35.0F - x, 0.15F);
}

/// At the end of a drive there is no key frame any more that would bring it.
TEST_F(FrontEndNode, GivesTheLocalMapToWhoComesLate) {
  drive(0, 14);
  ASSERT_TRUE(odometry_.wait_for(14));
  Listener<sensor_msgs::PointCloud2> maps("local_map");
  ASSERT_TRUE(maps.wait_for(1)) << node_->output();
  EXPECT_EQ(maps.messages.front().header.frame_id, "odom");
  EXPECT_EQ(from_ros(maps.messages.front().header.stamp), stamp_of(13));
  EXPECT_GT(maps.messages.front().width, 100U);
}

/// Every frame has another name here; rostest_mapping has the usual ones.
TEST_F(FrontEndNode, UsesTheNamesOfFramesThatItIsGiven) {
  Listener<sensor_msgs::PointCloud2> scans("current_scan");
  Listener<sensor_msgs::PointCloud2> maps("local_map");
  start({"_odom_frame:=track", "_base_frame:=car", "_map_frame:=world"});
  ASSERT_TRUE(wait_until([&] { return scans.connected() && maps.connected(); }));
  odometry_.messages.clear();
  tf_.messages.clear();
  key_frames_.messages.clear();
  for (int step = 0; step < 12; ++step) {
    clouds_.publish(
        ros_border::to_message(yard_seen_from(straight(step), 7U), stamp_of(step), "car"));
  }
  ASSERT_TRUE(odometry_.wait_for(1) && tf_.wait_for(1) && key_frames_.wait_for(1) &&
              status_.wait_for(1) && scans.wait_for(1) && maps.wait_for(1))
      << node_->output();
  EXPECT_EQ(odometry_.messages[0].header.frame_id, "track");
  EXPECT_EQ(odometry_.messages[0].child_frame_id, "car");
  EXPECT_EQ(tf_.messages[0].transforms.at(0).header.frame_id, "track");
  EXPECT_EQ(tf_.messages[0].transforms.at(0).child_frame_id, "car");
  EXPECT_EQ(key_frames_.messages[0].header.frame_id, "car");
  EXPECT_EQ(key_frames_.messages[0].lidar_origin.z, 0.0) << "a LiDAR alone is the vehicle";
  EXPECT_EQ(status_.messages.back().header.frame_id, "car");
  EXPECT_EQ(scans.messages[0].header.frame_id, "car");
  EXPECT_EQ(maps.messages[0].header.frame_id, "track");
}

/// Points that were moved to base_link from a place that nobody knows are not measured from there.
TEST_F(FrontEndNode, DoesNotInventThePlaceOfTheLidar) {
  start({"_lidar_frame:=nowhere"});
  key_frames_.messages.clear();
  drive(0, 12);
  ASSERT_TRUE(key_frames_.wait_for(1)) << node_->output();
  EXPECT_FALSE(ros_border::received(key_frames_.messages[0]).p_base_lidar);
}

/// tf gave the pose by the other publisher, and nobody said so.
TEST_F(FrontEndNode, NamesWhoElsePublishesTheVehicleInTf) {
  const auto others = connected_publisher<tf2_msgs::TFMessage>("/tf");
  tf2_msgs::TFMessage wheels;
  wheels.transforms.resize(1);
  wheels.transforms[0].header.frame_id = "wheels";
  wheels.transforms[0].child_frame_id = "base_link";
  wheels.transforms[0].transform.rotation.w = 1.0;
  drive(0, 4);
  const std::string warning = "tf has wheels -> base_link of " + ros::this_node::getName();
  EXPECT_EQ(node_->count("tf has"), 0U) << node_->output();
  for (int i = 0; i < 3; ++i) others.publish(wheels);
  EXPECT_TRUE(wait_until([&] { return node_->count(warning) == 1U; })) << node_->output();
}

TEST_F(FrontEndNode, ReportsItsStateInDiagnostics) {
  Listener<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  drive(0, 4);
  clouds_.publish(ros_border::to_message(PointCloud(), stamp_of(4), "base_link"));
  const auto says = [&](const std::string& message, const std::string& value) {
    for (const auto& array : diagnostics.messages) {
      for (const auto& status : array.status) {
        for (const auto& pair : status.values) {
          if (status.message == message && pair.value.find(value) != std::string::npos) return true;
        }
      }
    }
    return false;
  };
  EXPECT_TRUE(
      wait_until([&] { return says("tracking", "4 handled, 0 dropped, 0 lost, 1 refused"); }));
}

}  // namespace
}  // namespace lidar_mapping::test
