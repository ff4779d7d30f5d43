// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/session/session.hpp"

#include "bag_player.hpp"
#include "connections.hpp"
#include "listener.hpp"
#include "node_process.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kNodes = {"preprocessing_node", "floor_detection_node",
                                         "front_end_node",     "loop_closing_node",
                                         "back_end_node",      "map_viewer_node"};
/// Six nodes that start at once on a busy machine take their time.
constexpr double kStartSeconds = 2 * kPatience;
const std::vector<std::string> kAllTopics = {"points", "imu", "velocity", "gnss", "tf_static"};

using Coordinates = std::array<float, 3>;

std::set<Coordinates> points_of(const fs::path& pcd) {
  std::set<Coordinates> points;
  for (const Point& point : session::read_pcd(pcd).points) {
    points.insert({point.x, point.y, point.z});
  }
  return points;
}

/// All nodes on a few seconds of a simulated drive.
class Mapping : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    owner() = std::make_unique<TemporaryFolder>();
    NodeProcess simulation("simulate_drive", {bag(), "--lidar", "vlp16", "--duration", "12"});
    ASSERT_EQ(simulation.wait(100.0), 0) << simulation.output();
  }
  static void TearDownTestSuite() { owner().reset(); }
  static std::unique_ptr<TemporaryFolder>& owner() {
    static std::unique_ptr<TemporaryFolder> folder;
    return folder;
  }
  static const fs::path& folder() { return owner()->path(); }
  static std::string bag() { return (folder() / "drive.bag").string(); }

  void SetUp() override {
    for (const std::string& name : kNodes) start(name);
  }

  void start(const std::string& name) {
    std::vector<std::string> arguments;
    if (name == "back_end_node") {
      arguments.push_back("_session_directory:=" + (folder() / "sessions").string());
    }
    nodes_.erase(name);
    nodes_[name] = std::make_unique<NodeProcess>(name, arguments);
  }

  void connect(const std::vector<std::string>& topics) {
    player_.advertise(topics);
    wait_for_connections();
  }
  void wait_for_connections() const {
    ASSERT_TRUE(wait_until(
        [&] {
          return player_.connected() && ros::service::exists("save_map", false) &&
                 ros::service::exists("optimize_map", false);
        },
        kStartSeconds));
    for (const char* topic :
         {"synced_cloud", "synced_imu", "synced_velocity", "synced_gnss", "synced_inputs",
          "gnss_datum", "floor", "laser_odom", "front_end_status", "key_frame", "loop",
          "loop_verdict", "key_frame_poses", "graph_verdict", "optimized_odom"}) {
      ASSERT_TRUE(wait_until([&] { return is_connected(topic); }, kStartSeconds)) << topic;
    }
  }

  /// Sends up to `count` scans; waits for the nodes to follow, one scan behind: further ahead one
  /// sensor's connection may be so much faster than another's that a scan no longer waits for both.
  std::size_t drive(std::size_t count = 1000) {
    std::size_t sent = 0;
    while (sent < count && player_.send_next_scan()) {
      ++sent;
      ++sent_;
      if (sent_ > 1 && !odometry_.wait_for(sent_ - 1)) break;
    }
    return sent;
  }

  /// All that the front end has said of the scans so far is here, and the back end has all key
  /// frames; gives their number.
  std::size_t key_frames_of_all_scans() {
    EXPECT_TRUE(odometry_.wait_for(sent_) && status_.wait_for(sent_));
    const auto is_key_frame = [](const FrontEndStatusMessage& status) { return status.key_frame; };
    const auto count = static_cast<std::size_t>(
        std::count_if(status_.messages.begin(), status_.messages.end(), is_key_frame));
    EXPECT_TRUE(wait_until([&] { return indices().size() == count; }));
    GetKeyFrames known;
    EXPECT_TRUE(wait_until([&] {
      return ros::service::call("get_key_frames", known) &&
             known.response.key_frames.size() == count;
    })) << output_of_all();
    return count;
  }
  /// With the segment of each; a key frame may come again.
  std::set<std::pair<std::uint32_t, std::uint32_t>> indices() const {
    std::set<std::pair<std::uint32_t, std::uint32_t>> result;
    for (const KeyFrameMessage& message : key_frames_.messages) {
      result.emplace(message.index, message.segment);
    }
    return result;
  }

  /// The largest distance of the key frames to the truth, both seen from their first one.
  double error_of(const KeyFramePosesMessage& message) const {
    std::vector<std::pair<Pose, Pose>> pairs;
    for (std::size_t i = 0; i < message.indices.size(); ++i) {
      for (const nav_msgs::Odometry& truth : player_.truth()) {
        if (truth.header.stamp != message.stamps[i]) continue;
        pairs.emplace_back(ros_border::from_message(message.poses[i]),
                           ros_border::from_message(truth.pose.pose));
      }
    }
    double largest = pairs.empty() ? 1e9 : 0.0;
    for (const auto& [estimate, truth] : pairs) {
      const Pose T_first_estimate = pairs.front().first.inverse() * estimate;
      const Pose T_first_truth = pairs.front().second.inverse() * truth;
      largest =
          std::max(largest, (T_first_estimate.translation - T_first_truth.translation).norm());
    }
    return largest;
  }

  /// The map of the nodes' session without the nodes.
  static fs::path built_of_session() {
    const fs::path output = folder() / "build_map";
    NodeProcess program(
        "build_map", {(folder() / "sessions").string(), "-o", output.string(), "--formats", "pcd"});
    EXPECT_EQ(program.wait(100.0), 0) << program.output();
    return output;
  }
  /// The drive as map_bag maps it.
  static fs::path mapped_by_map_bag() {
    const fs::path output = folder() / "map_bag";
    NodeProcess program("map_bag", {bag(), "-o", output.string(), "--formats", "pcd"});
    EXPECT_EQ(program.wait(100.0), 0) << program.output();
    return output;
  }

  static Eigen::Vector3d lidar_of(const fs::path& session) {
    const auto found = session::Session::open(session, session::Session::Access::kRead);
    return found.sensor_origin().value_or(Eigen::Vector3d::Zero());
  }

  /// The largest distance between the nodes' key frames and those of map_bag from the same bag.
  static double difference(const KeyFramePosesMessage& message, const fs::path& output) {
    const auto session = session::Session::open(output, session::Session::Access::kRead);
    const std::vector<KeyFramePose> poses = session.poses().poses;
    EXPECT_EQ(poses.size(), message.poses.size());
    double largest = poses.empty() ? 1e9 : 0.0;
    for (std::size_t i = 0; i < std::min(poses.size(), message.poses.size()); ++i) {
      EXPECT_EQ(poses[i].stamp, ros_border::from_ros(message.stamps[i]));
      const Pose live = ros_border::from_message(message.poses[i]);
      largest = std::max(largest, (poses[i].T_map_base.translation - live.translation).norm());
    }
    return largest;
  }

  OptimizeMap::Response optimize() {
    OptimizeMap call;
    EXPECT_TRUE(ros::service::call("optimize_map", call));
    EXPECT_TRUE(call.response.success) << call.response.message;
    return call.response;
  }
  /// As the back end has them now; the newest message may still be on its way.
  KeyFramePosesMessage final_poses() {
    GetKeyFrames call;
    EXPECT_TRUE(ros::service::call("get_key_frames", call));
    return call.response.poses;
  }
  SaveMap::Response save() {
    SaveMap call;
    call.request.directory = (folder() / "map").string();
    EXPECT_TRUE(ros::service::call("save_map", call));
    return call.response;
  }
  std::string output_of(const std::string& node) const { return nodes_.at(node)->output(); }
  std::string output_of_all() const {
    std::string text;
    for (const auto& [name, node] : nodes_) text += node->output();
    return text;
  }

  BagPlayer player_{bag()};
  std::size_t sent_ = 0;
  std::map<std::string, std::unique_ptr<NodeProcess>> nodes_;
  Listener<nav_msgs::Odometry> odometry_{"laser_odom"};
  Listener<nav_msgs::Odometry> optimized_{"optimized_odom"};
  Listener<FrontEndStatusMessage> status_{"front_end_status"};
  Listener<KeyFrameMessage> key_frames_{"key_frame"};
  Listener<KeyFramePosesMessage> poses_{"key_frame_poses"};
};

TEST_F(Mapping, GivesAMapAndLosesNoScan) {
  connect(kAllTopics);
  std::size_t scans = 0;
  // The back end follows, too: on a machine whose disk is busy it would drop what it cannot keep.
  while (drive(1) == 1 && optimized_.wait_for(scans)) ++scans;
  ASSERT_GT(scans, 50U);
  EXPECT_TRUE(odometry_.wait_for(scans)) << output_of("front_end_node");
  EXPECT_EQ(odometry_.messages.size(), scans);
  EXPECT_TRUE(optimized_.wait_for(scans));
  const std::size_t key_frames = key_frames_of_all_scans();
  EXPECT_GT(key_frames, 5U);
  const OptimizeMap::Response optimized = optimize();
  EXPECT_EQ(optimized.key_frames, key_frames);
  EXPECT_GT(optimized.gnss_used, 0U);
  const KeyFramePosesMessage poses = final_poses();
  ASSERT_EQ(poses.indices.size(), optimized.key_frames);
  EXPECT_LT(error_of(poses), 0.3);
  const fs::path offline = mapped_by_map_bag();
  // The same bit for bit, unless this machine pauses for half a second: then what waits is taken as
  // it is.
  EXPECT_LT(difference(poses, offline), 0.005);
  const SaveMap::Response saved = save();
  ASSERT_TRUE(saved.success) << saved.message;
  for (const std::string& file : saved.files) EXPECT_GT(fs::file_size(file), 0U) << file;
  const std::set<Coordinates> live = points_of(folder() / "map" / "map.pcd");
  EXPECT_TRUE(live == points_of(built_of_session() / "map.pcd"))
      << "clouds and poses came through messages bit for bit";
  const auto others = static_cast<double>(points_of(offline / "map" / "map.pcd").size());
  EXPECT_NEAR(static_cast<double>(live.size()), others, 0.001 * others);
  EXPECT_EQ(lidar_of(folder() / "sessions"), lidar_of(offline)) << "from the frame of the clouds";
  EXPECT_EQ(saved.message.find("moving objects"), std::string::npos) << saved.message;
}

// LiDAR alone did not work.
TEST_F(Mapping, GivesAMapOfTheLidarAlone) {
  connect({"points", "tf_static"});
  const std::size_t scans = drive();
  EXPECT_TRUE(odometry_.wait_for(scans)) << output_of("front_end_node");
  const std::size_t key_frames = key_frames_of_all_scans();
  EXPECT_EQ(optimize().gnss_used, 0U);
  ASSERT_TRUE(wait_until([&] {
    return !poses_.messages.empty() && poses_.messages.back().indices.size() == key_frames;
  }));
  EXPECT_LT(error_of(final_poses()), 0.5);
  EXPECT_TRUE(save().success);
}

TEST_F(Mapping, GoesOnInANewSegmentAfterTheFrontEndWasKilled) {
  connect(kAllTopics);
  drive(40);
  const std::size_t before = key_frames_of_all_scans();
  nodes_.at("front_end_node")->kill();
  start("front_end_node");
  wait_for_connections();
  drive();
  const std::size_t after = key_frames_of_all_scans();
  ASSERT_GE(after, before + 3);
  std::size_t i = 0;
  for (const auto& [index, segment] : indices()) {
    EXPECT_EQ(index, i++);
    EXPECT_EQ(segment, index < before ? 0U : 1U);
  }
  EXPECT_EQ(key_frames_.messages.back().run_id, key_frames_.messages.front().run_id);
  EXPECT_EQ(optimize().key_frames, after);
}

// A missing transform muted the pipeline, or killed it.
TEST_F(Mapping, SaysWhichTransformIsMissingAndMakesNoMap) {
  connect({"points", "imu", "velocity", "gnss"});
  int sent = 0;
  const auto send = [&] {
    player_.send_next_scan();
    ++sent;
  };
  EXPECT_TRUE(send_until(send, [&] {
    return sent >= 20 && nodes_.at("preprocessing_node")
                             ->says("no transform from frame 'roof_lidar' to 'base_link'");
  })) << output_of("preprocessing_node");
  EXPECT_TRUE(odometry_.messages.empty());
  OptimizeMap call;
  ASSERT_TRUE(ros::service::call("optimize_map", call));
  EXPECT_FALSE(call.response.success);
  EXPECT_FALSE(call.response.message.empty());
  EXPECT_FALSE(save().success);
}

/// The nodes as users start them.
class LaunchedMapping : public Mapping {
 protected:
  void SetUp() override {
    nodes_["roslaunch"] = std::make_unique<NodeProcess>(
        "/usr/bin/env",
        std::vector<std::string>{"roslaunch", "lidar_mapping", "mapping.launch", "rviz:=false",
                                 "use_sim_time:=false", "points:=/points", "imu:=/imu",
                                 "velocity:=/velocity", "gnss:=/gnss",
                                 "session_directory:=" + (folder() / "launched").string()});
  }

  /// All at once; returns when roslaunch has started them again.
  void kill(const std::vector<std::string>& names) {
    std::map<std::string, int> killed;
    for (const std::string& name : names) killed[name] = process_of(name);
    for (const auto& [name, process] : killed) {
      ASSERT_GT(process, 0) << name;
      ::kill(process, SIGKILL);
    }
    for (const auto& [name, process] : killed) {
      const auto is_back = [&name = name, process = process] {
        const int now = process_of(name);
        return now > 0 && now != process;
      };
      ASSERT_TRUE(wait_until(is_back, kStartSeconds))
          << name << " did not come back: " << output_of("roslaunch");
    }
    wait_for_connections();
  }
  std::size_t sessions() const {
    const fs::directory_iterator entries(folder() / "launched");
    return static_cast<std::size_t>(std::count_if(
        begin(entries), end(entries), [](const auto& entry) { return !entry.is_symlink(); }));
  }
};

// What was killed lost the drive.
TEST_F(LaunchedMapping, IsCompleteAfterEveryNodeWasKilledInMidDrive) {
  connect(kAllTopics);
  drive(20);
  for (const std::string& name : kNodes) {
    key_frames_of_all_scans();  // what a killed node had not sent yet would be lost
    kill({name});
    drive(12);
  }
  key_frames_of_all_scans();
  kill({"front_end_node", "back_end_node"});
  drive();
  const std::size_t count = key_frames_of_all_scans();
  const auto last = *indices().rbegin();
  EXPECT_EQ(last.first + 1, count) << "none twice, none left out";
  EXPECT_EQ(last.second, 2U) << "one more segment each time that the front end was killed";
  EXPECT_EQ(optimize().key_frames, count);
  EXPECT_EQ(sessions(), 1U);
  const std::string all = "of " + std::to_string(count) + " key frames";
  const SaveMap::Response saved = save();
  EXPECT_NE(saved.message.find(all), std::string::npos) << saved.message << ", not " << all;
  EXPECT_EQ(saved.message.find("moving objects"), std::string::npos) << saved.message;
  EXPECT_LT(error_of(final_poses()), 0.5) << "the segments lie in one map";
}

}  // namespace
}  // namespace lidar_mapping::test
