// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>
#include <set>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <ros/ros.h>

#include "listener.hpp"
#include "node_process.hpp"

namespace lidar_mapping::test {
namespace {

class EveryNode : public testing::TestWithParam<const char*> {
 protected:
  std::string name() const { return GetParam(); }
};

// A wrong value crashed later, or had no effect.
TEST_P(EveryNode, EndsWithALinePerProblemBeforeItTouchesData) {
  NodeProcess node(name(), {"_queue_size:=0", "_base_frame:=/base_link"});
  EXPECT_EQ(node.wait(), 1);
  EXPECT_TRUE(node.says("/" + name() + ": queue_size: 0 is out of range; allowed: integer from 1"))
      << node.output();
  EXPECT_TRUE(node.says("'/base_link' starts with a slash")) << node.output();
}

// A misspelt key was ignored in silence.
TEST_P(EveryNode, EndsForAnUnknownKeyAndSuggestsTheRightOne) {
  NodeProcess node(name(), {"_base_farme:=vehicle"});
  EXPECT_EQ(node.wait(), 1);
  EXPECT_TRUE(node.says("unknown key 'base_farme' (value vehicle); did you mean 'base_frame'"))
      << node.output();
}

TEST_P(EveryNode, PrintsItsConfigurationInForce) {
  NodeProcess node(name(), {"--print-config", "_base_frame:=vehicle"});
  EXPECT_EQ(node.wait(), 0);
  EXPECT_TRUE(node.says("base_frame: \"vehicle\"")) << node.output();
}

TEST_P(EveryNode, ExplainsItselfWithoutAMaster) {
  NodeProcess node(name(), {"--help", "__master:=http://localhost:1"});
  EXPECT_EQ(node.wait(), 0);
  EXPECT_TRUE(node.says("--print-config")) << node.output();
  EXPECT_TRUE(node.says("describe_config")) << node.output();
}

TEST_P(EveryNode, EndsForAnOptionThatItDoesNotKnow) {
  NodeProcess node(name(), {"--print-confg"});
  EXPECT_NE(node.wait(), 0);
  EXPECT_TRUE(node.says("--print-confg")) << node.output();
}

// Frames, topics and paths were compiled in; two instances could not run beside each other.
TEST_P(EveryNode, StartsInTwoNamespacesAtOnceAndEndsWhenAsked) {
  NodeProcess one(name(), {"__ns:=one"});
  NodeProcess two(name(), {"__ns:=two"});
  const auto alive = [&](const std::string& space) {
    std::vector<std::string> nodes;
    ros::master::getNodes(nodes);
    return std::find(nodes.begin(), nodes.end(), "/" + space + "/" + name()) != nodes.end();
  };
  EXPECT_TRUE(wait_until([&] { return alive("one") && alive("two"); }));
  one.stop();
  two.stop();
  EXPECT_EQ(one.wait(0.0), 0) << one.output();
  EXPECT_EQ(two.wait(0.0), 0) << two.output();
}

/// Started again it would say the same once a second.
TEST_P(EveryNode, StaysAndDoesNothingWhereItWouldBeStartedAgain) {
  Listener<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  NodeProcess node(name(), {"--stay-on-error", "_queue_size:=0"});
  const auto reported = [&] {
    return std::any_of(
        diagnostics.messages.begin(), diagnostics.messages.end(), [](const auto& message) {
          return message.status.at(0).level == diagnostic_msgs::DiagnosticStatus::ERROR &&
                 message.status.at(0).message.find("queue_size: 0") != std::string::npos;
        });
  };
  EXPECT_TRUE(wait_until(reported)) << node.output();
  EXPECT_TRUE(node.says("correct the error above")) << node.output();
  node.stop();
  EXPECT_EQ(node.wait(0.0), 1);
}

TEST_P(EveryNode, ReportsWhereItRunsAndEachFigureOnce) {
  Listener<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  const NodeProcess node(name());
  ASSERT_TRUE(diagnostics.wait_for(2)) << node.output();
  for (const auto& message : diagnostics.messages) {
    const auto& status = message.status.at(0);
    EXPECT_NE(status.hardware_id, "");
    EXPECT_NE(status.hardware_id, "none");
    std::set<std::string> keys;
    for (const auto& value : status.values) {
      EXPECT_TRUE(keys.insert(value.key).second) << value.key << " twice";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Nodes, EveryNode,
                         testing::Values("preprocessing_node", "floor_detection_node",
                                         "front_end_node", "loop_closing_node", "back_end_node",
                                         "map_viewer_node", "localization_node"));

TEST(Launch, AWrongParameterIsSaidOnceByEachNodeAndNoneIsStartedAgain) {
  NodeProcess launch("/usr/bin/env", {"roslaunch", "lidar_mapping", "mapping.launch", "rviz:=false",
                                      "map_frame:=/map"});
  EXPECT_TRUE(wait_until([&] { return launch.count("this node does nothing") == 6; }))
      << launch.output();
  EXPECT_EQ(launch.count("map_frame: '/map' starts with a slash"), 6U) << launch.output();
  EXPECT_EQ(launch.count("has died"), 0U) << launch.output();
  launch.stop();
  ros::param::del("/nodes");
  ros::param::del("/use_sim_time");
}

TEST(Launch, ListsEveryArgumentAsOptionalAndWithItsMeaning) {
  for (const char* file : {"mapping.launch", "localization.launch", "demo.launch"}) {
    NodeProcess launch("/usr/bin/env", {"roslaunch", "--ros-args", "lidar_mapping", file});
    EXPECT_EQ(launch.wait(), 0) << launch.output();
    EXPECT_TRUE(launch.says("Optional Arguments")) << launch.output();
    EXPECT_FALSE(launch.says("Required Arguments")) << launch.output();
    EXPECT_FALSE(launch.says("undocumented")) << launch.output();
  }
}

/// No shell does it in `config:=~/my_config`.
TEST(Launch, FindsTheHomeFolder) {
  const TemporaryFolder home;
  const std::filesystem::path folder = home.path() / "my_config";
  std::filesystem::create_directory(folder);
  for (const char* stage : {"preprocessing", "floor_detection", "front_end", "loop_closing",
                            "back_end", "map", "overlay"}) {
    std::ofstream(folder / (std::string(stage) + ".yaml")) << stage << "_mark: 7\n";
  }
  NodeProcess launch("/usr/bin/env",
                     {"HOME=" + home.path().string(), "roslaunch", "--dump-params", "lidar_mapping",
                      "mapping.launch", "config:=~/my_config", "sensor:=~/my_config/overlay.yaml",
                      "map_cloud_update_interval:=3"});
  EXPECT_EQ(launch.wait(), 0) << launch.output();
  for (const char* mark :
       {"/preprocessing_node/preprocessing_mark: 7", "/map_viewer_node/map_mark: 7",
        "/overlays/sensor/overlay_mark: 7", "/map_viewer_node/map_cloud_update_interval: 3"}) {
    EXPECT_TRUE(launch.says(mark)) << mark << "\n" << launch.output();
  }
}

/// The parameters that mapping.launch would set, as text.
std::string parameters_of(std::vector<std::string> arguments, const std::string& home) {
  arguments.insert(arguments.begin(), {"HOME=" + home, "roslaunch", "--dump-params",
                                       "lidar_mapping", "mapping.launch"});
  NodeProcess launch("/usr/bin/env", arguments);
  EXPECT_EQ(launch.wait(), 0) << launch.output();
  return launch.output();
}

/// An argument that nobody gave overwrote what stood in the files.
TEST(Launch, ItsDefaultsAreOverriddenByTheFilesOfTheUser) {
  const TemporaryFolder home;
  for (const char* stage :
       {"preprocessing", "floor_detection", "front_end", "loop_closing", "back_end"}) {
    std::ofstream(home.path() / (std::string(stage) + ".yaml")) << "lidar_frame: of_the_file\n";
  }
  std::ofstream(home.path() / "map.yaml") << "map_cloud_update_interval: 3.5\n";
  const std::string folder = "config:=" + home.path().string();
  const std::vector<std::string> nodes = {"front_end_node", "loop_closing_node", "back_end_node"};
  const auto expect = [&](const std::string& output, const std::string& frame,
                          const std::string& interval) {
    for (const std::string& node : nodes) {
      const std::string line = "/" + node + "/lidar_frame: " + frame + "\n";
      EXPECT_EQ(output.find(line) != std::string::npos, !frame.empty()) << output;
    }
    if (frame.empty()) {
      EXPECT_EQ(output.find("lidar_frame"), std::string::npos) << output;
    }
    const std::string line = "/map_viewer_node/map_cloud_update_interval: " + interval;
    EXPECT_EQ(output.find(line) != std::string::npos, !interval.empty()) << output;
    if (interval.empty()) {
      EXPECT_EQ(output.find("map_cloud_update_interval"), std::string::npos) << output;
    }
  };
  expect(parameters_of({folder}, home.path()), "of_the_file", "3.5");
  expect(parameters_of({folder, "lidar_frame:=given", "map_cloud_update_interval:=2"}, home.path()),
         "given", "2");
  expect(parameters_of({}, home.path()), "", "");
}

TEST(Launch, TakesPresetsByNameAndByPath) {
  const TemporaryFolder home;
  std::ofstream(home.path() / "hall.yaml") << "front_end: {key_frame_distance: 0.75}\n";
  const std::string by_name = parameters_of({"preset:=indoor"}, home.path());
  EXPECT_NE(by_name.find("/overlays/preset/front_end/key_frame_distance: 0.5"), std::string::npos)
      << by_name;
  const std::string by_path = parameters_of({"preset:=~/hall.yaml"}, home.path());
  EXPECT_NE(by_path.find("/overlays/preset/front_end/key_frame_distance: 0.75"), std::string::npos)
      << by_path;
}

TEST(Launch, RemapsTheTopicOfAnotherOdometry) {
  NodeProcess launch("/usr/bin/env", {"roslaunch", "--args", "front_end_node", "lidar_mapping",
                                      "mapping.launch", "external_odom:=/wheels/odom"});
  EXPECT_EQ(launch.wait(), 0) << launch.output();
  EXPECT_TRUE(launch.says("external_odom:=/wheels/odom")) << launch.output();
}

TEST(Launch, RemapsTheTopicOfOtherLidars) {
  for (const char* file : {"mapping.launch", "localization.launch"}) {
    NodeProcess launch("/usr/bin/env", {"roslaunch", "--args", "preprocessing_node",
                                        "lidar_mapping", file, "other_points:=/left"});
    EXPECT_EQ(launch.wait(), 0) << launch.output();
    EXPECT_TRUE(launch.says("other_points:=/left")) << file << "\n" << launch.output();
  }
}

/// Overlays on the server for as long as this lives.
struct Overlays {
  Overlays() = default;
  Overlays(const Overlays&) = delete;
  Overlays& operator=(const Overlays&) = delete;
  ~Overlays() {
    ros::param::del("/overlays");
    ros::param::del("/nodes");
  }
};

TEST(Overlay, ThatOfThePlaceWinsOverThatOfTheSensorAndThatOverPrivateParameters) {
  const Overlays overlays;
  ros::param::set("/overlays/sensor/front_end/key_frame_distance", 7.5);
  ros::param::set("/overlays/sensor/front_end/key_frame_angle", 0.2);
  ros::param::set("/overlays/preset/front_end/key_frame_angle", 0.4);
  ros::param::set("/nodes/odom_frame", "odometry");
  ros::param::set("/nodes/map_frame", "world");
  ros::param::set("/overlays/sensor/nodes/map_frame", "site");
  NodeProcess node("front_end_node", {"--print-config", "_key_frame_distance:=3.0"});
  EXPECT_EQ(node.wait(), 0);
  for (const char* line : {"key_frame_distance: 7.5", "key_frame_angle: 0.4",
                           "odom_frame: \"odometry\"", "map_frame: \"site\""}) {
    EXPECT_TRUE(node.says(line)) << line << "\n" << node.output();
  }
}

/// It lay on the server without an effect.
TEST(Overlay, WithAGroupOfNoStageEndsEveryNode) {
  const Overlays overlays;
  ros::param::set("/overlays/sensor/preprocesing/scan_period", 0.05);
  for (const char* name : {"preprocessing_node", "map_viewer_node", "localization_node"}) {
    NodeProcess node(name);
    EXPECT_EQ(node.wait(), 1) << node.output();
    EXPECT_TRUE(
        node.says("/overlays/sensor: no stage has the name 'preprocesing'; an overlay has "
                  "groups of the names nodes, back_end"))
        << node.output();
  }
}

/// What the user had written into the file of the stage went unnoticed.
TEST(Overlay, ThatReplacesAValueOfTheUserIsSaid) {
  const Overlays overlays;
  ros::param::set("/overlays/sensor/front_end/key_frame_distance", 7.5);
  ros::param::set("/overlays/sensor/front_end/key_frame_angle", 0.2);
  NodeProcess node("front_end_node", {"--print-config", "_key_frame_distance:=3.0"});
  EXPECT_EQ(node.wait(), 0);
  EXPECT_TRUE(
      node.says("key_frame_distance: 7.5 of /overlays/sensor is in force, not 3.0 of "
                "/front_end_node"))
      << node.output();
  EXPECT_FALSE(node.says("key_frame_angle: 0.2 of")) << "nobody has set it before";
}

TEST(EffectiveConfiguration, IsLeftOnTheParameterServer) {
  ros::param::del("/effective_configuration");
  NodeProcess node("front_end_node", {"_key_frame_distance:=3.0"});
  std::string yaml;
  ASSERT_TRUE(
      wait_until([&] { return ros::param::get("/effective_configuration/front_end", yaml); }));
  EXPECT_NE(yaml.find("key_frame_distance: 3.0"), std::string::npos) << yaml;
}

}  // namespace
}  // namespace lidar_mapping::test
