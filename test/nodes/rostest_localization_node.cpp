// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "lidar_mapping/localization/localizer.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/transforms.hpp"
#include "lidar_mapping/session/session.hpp"

#include "bag_player.hpp"
#include "listener.hpp"
#include "near.hpp"
#include "node_process.hpp"
#include "scan_points.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;
using ros_border::from_message;
using ros_border::from_ros;
using session::Session;

/// The nodes of localization.launch on a few seconds of a drive, in the map of another day.
class LocalizationNode : public testing::Test {
 protected:
  /// `more` are arguments of localization_node.
  explicit LocalizationNode(const std::string& drive = "driven",
                            const std::vector<std::string>& more = {})
      : player_(bag(drive)), arguments_({"_map:=" + map()}) {
    arguments_.insert(arguments_.end(), more.begin(), more.end());
  }

  static void SetUpTestSuite() {
    if (owner()) return;  // of a suite before
    owner() = std::make_unique<TemporaryFolder>();
    run("simulate_drive", {bag("mapped"), "--lidar", "vlp16", "--duration", "16"});
    run("simulate_drive", {bag("driven"), "--lidar", "vlp16", "--pass", "1", "--parked", "1",
                           "--start", "3", "--duration", "13"});
    run("map_bag", {bag("mapped"), "-o", map(), "--no-map"});
  }
  static std::unique_ptr<TemporaryFolder>& owner() {
    static std::unique_ptr<TemporaryFolder> folder;
    return folder;
  }
  static std::string bag(const std::string& name) { return owner()->path() / (name + ".bag"); }
  static std::string map() { return owner()->path() / "map"; }
  static void run(const std::string& program, const std::vector<std::string>& words) {
    NodeProcess process(program, words);
    ASSERT_EQ(process.wait(200.0), 0) << process.output();
  }

  void SetUp() override {
    start("preprocessing_node", {});
    start("front_end_node", {});
    start("localization_node", arguments_);
    player_.advertise({"points", "imu", "velocity", "gnss", "tf_static"});
    ASSERT_TRUE(wait_until(
        [&] {
          return player_.connected() && is_connected("laser_odom") &&
                 is_connected("current_scan") && is_connected("synced_cloud") &&
                 status_.connected() && pose_.connected() && map_cloud_.messages.size() == 1;
        },
        3 * kPatience))
        << nodes_["localization_node"]->output();
  }
  void start(const std::string& name, const std::vector<std::string>& arguments) {
    nodes_[name] = std::make_unique<NodeProcess>(name, arguments);
  }

  /// Sends up to `count` scans; of the last one that was sent no status comes before the next is.
  void drive(std::size_t count = 1000) {
    for (std::size_t i = 0; i < count && player_.send_next_scan(); ++i) {
      ++sent_;
      if (sent_ > 1 && !status_.wait_for(sent_ - 1)) {
        FAIL() << "no status of scan " << sent_ - 1 << "\n"
               << nodes_["localization_node"]->output();
      }
    }
  }
  const LocalizationStatusMessage& last() const { return status_.messages.back(); }

  /// Of the simulated world: where the map lies in it by its first key frame.
  static Pose T_truth_map() {
    const KeyFramePose first = Session::open(map(), Session::Access::kRead).poses().poses.front();
    return truth_at(BagPlayer(bag("mapped")).truth(), first.stamp) * first.T_map_base.inverse();
  }
  static Pose truth_at(const std::vector<nav_msgs::Odometry>& truth, Stamp stamp) {
    const auto found = std::find_if(truth.begin(), truth.end(), [&](const auto& message) {
      return from_ros(message.header.stamp) == stamp;
    });
    if (found == truth.end()) throw std::runtime_error("the truth lacks a stamp");
    return from_message(found->pose.pose);
  }

  /// The message at a stamp; null if there is none.
  template <typename Message>
  static const Message* at_stamp(const std::vector<Message>& messages, const ros::Time& stamp) {
    const auto found = std::find_if(messages.begin(), messages.end(), [&](const Message& message) {
      return message.header.stamp == stamp;
    });
    return found == messages.end() ? nullptr : &*found;
  }
  /// The points of a scan at its pose, in their order, many of which the map knows.
  static void expect_points_in_the_map(const sensor_msgs::PointCloud2& cloud,
                                       const registration::NdtPoints& points,
                                       const Pose& T_map_base) {
    sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z"),
        agreement(cloud, "agreement");
    double sum = 0.0;
    std::size_t known = 0;
    for (std::size_t i = 0; i < points.size(); ++i, ++x, ++y, ++z, ++agreement) {
      const Eigen::Vector3d p_base(points.x()[i], points.y()[i], points.z()[i]);
      EXPECT_TRUE(near(T_map_base * p_base, Eigen::Vector3d(*x, *y, *z), 1e-3)) << i;
      if (*agreement == localization::kNotInMap) continue;
      EXPECT_TRUE(*agreement >= 0.0F && *agreement <= 1.0F) << *agreement;
      sum += *agreement;
      ++known;
    }
    EXPECT_GT(4 * known, points.size());
    EXPECT_GT(sum, 0.3 * static_cast<double>(known));
  }

  BagPlayer player_;
  std::vector<std::string> arguments_;
  std::map<std::string, std::unique_ptr<NodeProcess>> nodes_;
  std::size_t sent_ = 0;
  Listener<LocalizationStatusMessage> status_{"localization_status"};
  Listener<geometry_msgs::PoseWithCovarianceStamped> pose_{"localization_node/pose"};
  Listener<nav_msgs::Odometry> odometry_{"localized_odom"};
  Listener<nav_msgs::Odometry> laser_odom_{"laser_odom"};
  Listener<nav_msgs::Path> path_{"localized_path"};
  Listener<sensor_msgs::PointCloud2> map_cloud_{"localization_map"};
  Listener<tf2_msgs::TFMessage> tf_{"tf"};
};

TEST_F(LocalizationNode, FindsItselfAndPublishesWhereItIs) {
  drive();
  ASSERT_EQ(last().state, "following") << last().reason;
  EXPECT_GT(last().probability, 0.99);
  ASSERT_TRUE(pose_.wait_for(40) && odometry_.wait_for(40) && path_.wait_for(5));
  const Pose T_truth = T_truth_map();
  for (const auto& message : pose_.messages) {
    EXPECT_EQ(message.header.frame_id, "map");
    EXPECT_GT(message.pose.covariance[0], 0.0);
    const Pose truth = truth_at(player_.truth(), from_ros(message.header.stamp));
    EXPECT_TRUE(near(T_truth * from_message(message.pose.pose), truth, 0.2, 0.01));
  }
  for (const auto& message : odometry_.messages) {
    const auto* const odometry = at_stamp(laser_odom_.messages, message.header.stamp);
    ASSERT_NE(odometry, nullptr);
    EXPECT_NEAR(message.twist.twist.linear.x, odometry->twist.twist.linear.x, 1e-9);
    EXPECT_GT(message.twist.covariance[0], 0.0);
    EXPECT_NEAR(message.twist.covariance[0], odometry->twist.covariance[0], 1e-9);
  }
  EXPECT_EQ(path_.messages.back().header.frame_id, "map");
  EXPECT_GT(map_cloud_.messages.front().width, 1000U);
}

TEST_F(LocalizationNode, GivesTheMatchedPointsWithTheirAgreement) {
  const Listener<sensor_msgs::PointCloud2> seen("current_scan"), matched("localized_scan");
  ASSERT_TRUE(wait_until([&] { return seen.connected() && matched.connected(); }));
  ros_border::SensorFrames frames;
  const auto p_base_lidar = [&] { return frames.origin_of(BagPlayer::kLidarFrame, "base_link"); };
  drive(40);
  ASSERT_TRUE(wait_until([&] { return !matched.messages.empty() && p_base_lidar().has_value(); }));
  const auto has_pose = [&](const auto& cloud) {
    return at_stamp(pose_.messages, cloud.header.stamp) != nullptr;
  };
  EXPECT_TRUE(wait_until([&] {
    return std::all_of(matched.messages.begin(), matched.messages.end(), has_pose);
  })) << "without a pose there is nothing to show";
  const auto cloud =
      std::find_if(matched.messages.rbegin(), matched.messages.rend(), [&](const auto& message) {
        return has_pose(message) && at_stamp(seen.messages, message.header.stamp) != nullptr;
      });
  ASSERT_NE(cloud, matched.messages.rend());
  EXPECT_EQ(cloud->header.frame_id, "map");
  const auto& scan = *at_stamp(seen.messages, cloud->header.stamp);
  const registration::NdtPoints points =
      localization::ScanPointSampler().sample(ros_border::from_message(scan), *p_base_lidar()).all;
  ASSERT_EQ(cloud->width * cloud->height, points.size());
  const auto& pose = *at_stamp(pose_.messages, cloud->header.stamp);
  expect_points_in_the_map(*cloud, points, from_message(pose.pose.pose));
}

TEST_F(LocalizationNode, GivesTheTransformThatTheOdometryLacks) {
  drive(30);
  ASSERT_TRUE(pose_.wait_for(1));
  const auto& pose = pose_.messages.back();
  const auto odometry =
      std::find_if(laser_odom_.messages.begin(), laser_odom_.messages.end(),
                   [&](const auto& message) { return message.header.stamp == pose.header.stamp; });
  ASSERT_NE(odometry, laser_odom_.messages.end());
  const Pose T_map_odom =
      from_message(pose.pose.pose) * from_message(odometry->pose.pose).inverse();
  const auto is_sent = [&](const tf2_msgs::TFMessage& message) {
    const auto& transform = message.transforms.at(0);
    return transform.header.frame_id == "map" && transform.child_frame_id == "odom" &&
           transform.header.stamp == pose.header.stamp &&
           near(from_message(transform.transform), T_map_odom, 1e-6);
  };
  EXPECT_TRUE(
      wait_until([&] { return std::any_of(tf_.messages.begin(), tf_.messages.end(), is_sent); }));
}

TEST_F(LocalizationNode, SearchesAgainAndReadsAnotherMapWhenAsked) {
  drive(40);
  ASSERT_EQ(last().state, "following") << last().reason;
  Relocalize again;
  ASSERT_TRUE(ros::service::call("relocalize", again));
  EXPECT_TRUE(again.response.success) << again.response.message;
  drive(2);
  EXPECT_EQ(last().state, "searching") << last().reason;
  drive(30);
  EXPECT_EQ(last().state, "following") << last().reason;
  LoadMap wrong;
  wrong.request.path = owner()->path() / "nothing";
  ASSERT_TRUE(ros::service::call("load_map", wrong));
  EXPECT_FALSE(wrong.response.success);
  EXPECT_NE(wrong.response.message.find("there is no session in"), std::string::npos)
      << wrong.response.message;
  drive(2);
  EXPECT_EQ(last().state, "following") << last().reason;  // in the map before
  LoadMap right;
  right.request.path = map();
  ASSERT_TRUE(ros::service::call("load_map", right));
  EXPECT_TRUE(right.response.success) << right.response.message;
  drive(2);
  EXPECT_EQ(last().state, "searching") << last().reason;
  SaveSession save;
  save.request.path = owner()->path() / "not_recorded";
  ASSERT_TRUE(ros::service::call("save_session", save));
  EXPECT_FALSE(save.response.success);
  EXPECT_NE(save.response.message.find("record_session: true"), std::string::npos)
      << save.response.message;
}

TEST_F(LocalizationNode, SaysThatNoScansCome) {
  drive(30);
  ASSERT_EQ(last().state, "following") << last().reason;
  ASSERT_TRUE(wait_until([&] { return last().state == "lost"; })) << last().reason;
  EXPECT_NE(last().reason.find("no scan for"), std::string::npos) << last().reason;
  const std::size_t silent = status_.messages.size();
  drive(10);
  EXPECT_GT(status_.messages.size(), silent);
  EXPECT_NE(last().reason.substr(0, 11), "no scan for");
}

/// The same with a drive that goes on beyond the map, and is recorded.
class RecordedDrive : public LocalizationNode {
 protected:
  RecordedDrive() : LocalizationNode("beyond", {"_record_session:=true"}) {}

  static void SetUpTestSuite() {
    LocalizationNode::SetUpTestSuite();
    run("simulate_drive", {bag("beyond"), "--lidar", "vlp16", "--pass", "1", "--parked", "1",
                           "--start", "3", "--duration", "32"});
  }
  void SetUp() override {
    LocalizationNode::SetUp();
    ASSERT_TRUE(
        wait_until([] { return is_connected("key_frame") && is_connected("front_end_status"); }));
  }
  static std::string folder(const std::string& name) { return owner()->path() / name; }
  static SaveSession::Response save(const std::string& name) {
    SaveSession call;
    call.request.path = folder(name);
    EXPECT_TRUE(ros::service::call("save_session", call));
    return call.response;
  }
  /// No session is written, and the message says why.
  static void expect_refused(const std::string& name, const std::string& reason) {
    const SaveSession::Response answer = save(name);
    EXPECT_FALSE(answer.success);
    EXPECT_EQ(answer.key_frames, 0U);
    EXPECT_NE(answer.message.find(reason), std::string::npos) << answer.message;
  }
  static Session opened(const std::string& path) {
    return Session::open(path, Session::Access::kRead);
  }
};

TEST_F(RecordedDrive, ExtendsTheMapByWhatLiesBeyondIt) {
  drive();
  const SaveSession::Response answer = save("extended");
  ASSERT_TRUE(answer.success) << answer.message << "\n" << nodes_["localization_node"]->output();
  EXPECT_NE(answer.message.find("added to the map: "), std::string::npos) << answer.message;
  EXPECT_GT(answer.key_frames, 20U) << answer.message;
  const Session extended = opened(folder("extended")), old = opened(map());
  EXPECT_EQ(extended.key_frame_count(), old.key_frame_count() + answer.key_frames);
  const KeyFrameIndex last_of_map = old.key_frames().back().index;
  const Pose T_truth = T_truth_map();
  for (const KeyFramePose& pose : extended.poses().poses) {
    EXPECT_TRUE(extended.clouds().contains(pose.index)) << pose.index;
    if (pose.index <= last_of_map) continue;
    // The map lies askew by the noise of GNSS, and its end is far from its first key frame.
    const Pose truth = truth_at(player_.truth(), pose.stamp);
    EXPECT_TRUE(near(T_truth * pose.T_map_base, truth, 3.0, 0.05)) << pose.index;
  }
  EXPECT_FALSE(extended.scans().empty());
  EXPECT_GT(extended.odometry().size(), old.odometry().size());
  expect_refused("extended", "exists and is no empty folder");
  const SaveSession::Response again = save("again");
  EXPECT_TRUE(again.success) << again.message;
  EXPECT_GE(again.key_frames, answer.key_frames);
}

TEST_F(RecordedDrive, SaysWhyThereIsNothingToSave) {
  drive(3);
  expect_refused("empty", "was not found in the map");
  drive(50);
  ASSERT_EQ(last().state, "following") << last().reason;
  expect_refused("inside", "so no session is written");
  Relocalize again;
  ASSERT_TRUE(ros::service::call("relocalize", again));
  expect_refused("withdrawn", "was not found in the map");
  drive(40);
  ASSERT_EQ(last().state, "following") << last().reason;
  expect_refused("found_again", "so no session is written");
  LoadMap other;
  other.request.path = map();
  ASSERT_TRUE(ros::service::call("load_map", other));
  EXPECT_TRUE(other.response.success) << other.response.message;
  expect_refused("anew", "was not found in the map");
  expect_refused("", "exists and is no empty folder");
}

TEST(LocalizationNodeAlone, EndsForAMapThatDoesNotExist) {
  NodeProcess node("localization_node", {"_map:=/no/such/session"});
  EXPECT_EQ(node.wait(), 1);
  EXPECT_TRUE(node.says("/no/such/session")) << node.output();
}

}  // namespace
}  // namespace lidar_mapping::test
