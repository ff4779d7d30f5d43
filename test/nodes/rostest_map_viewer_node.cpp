// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "listener.hpp"
#include "map_viewer_fixture.hpp"
#include "node_process.hpp"

namespace lidar_mapping::test {
namespace {

// Who subscribes after the fact sees everything; stamps are those of the data.
TEST_F(MapViewerNode, ShowsMapPathsAndGraphToWhoComesLate) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  ros::NodeHandle handle;
  auto poses = handle.advertise<KeyFramePosesMessage>("key_frame_poses", 1, true);
  poses.publish(corrected(kRound, 1));
  Listener<nav_msgs::Path> path("optimized_path");
  ASSERT_TRUE(wait_until([&] {
    return !path.messages.empty() && path.messages.back().poses.size() == kRound &&
           std::abs(path.messages.back().poses.back().pose.position.x) < 0.01;
  })) << node.output();
  EXPECT_EQ(ros_border::from_ros(path.messages.back().header.stamp),
            round_key_frame(kRound - 1).stamp);
  Listener<sensor_msgs::PointCloud2> map("global_map");
  Listener<nav_msgs::Path> odometry("odom_path");
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  ASSERT_TRUE(map.wait_for(1) && odometry.wait_for(1) && markers.wait_for(1)) << node.output();
  EXPECT_EQ(map.messages[0].header.frame_id, "map");
  EXPECT_EQ(ros_border::from_ros(map.messages[0].header.stamp), round_key_frame(kRound - 1).stamp);
  EXPECT_GT(map.messages[0].width * map.messages[0].height, 500U);
  EXPECT_EQ(odometry.messages[0].poses.size(), static_cast<std::size_t>(kRound));
  std::set<std::string> shown;
  for (const auto& marker : markers.messages[0].markers) shown.insert(marker.ns);
  EXPECT_EQ(shown, std::set<std::string>({"", "age", "key_frames", "odometry", "status"}));
}

TEST_F(MapViewerNode, ShowsFixesAndFloorsOfBeforeItCame) {
  store(3);
  nav_msgs::Odometry fix;
  fix.header.stamp = ros_border::to_ros(round_key_frame(1).stamp);
  fix.pose.pose.orientation.w = 1.0;
  fixes_.push_back(fix);
  Floor floor;
  floor.stamp = round_key_frame(2).stamp;
  floor.found = true;
  floor.offset = 1.8;
  floors_.push_back(ros_border::to_message(floor, "base_link"));
  const NodeProcess node("map_viewer_node");
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  std::set<std::string> shown;
  EXPECT_TRUE(wait_until([&] {
    for (const auto& message : markers.messages) {
      for (const auto& marker : message.markers) shown.insert(marker.ns);
    }
    return shown.count("gnss") > 0 && shown.count("floors") > 0;
  })) << node.output();
}

/// Those of a second drive, whose first fix is 70 m east of that of the session.
TEST_F(MapViewerNode, ShowsFixesInTheAxesOfTheSession) {
  constexpr double kEast = 70.0;  // m
  ros::param::set("/run_state/session_datum", "49 8.4 115 run");
  const NodeProcess node("map_viewer_node");
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  const auto data = connected_publisher<sensor_msgs::NavSatFix>("gnss_datum");
  sensor_msgs::NavSatFix datum;
  datum.latitude = 49.0;
  datum.longitude = 8.4 + kEast / 6391000.0 / std::cos(49.0 * M_PI / 180.0) * 180.0 / M_PI;
  datum.altitude = 115.0;
  data.publish(datum);
  const auto fixes = connected_publisher<nav_msgs::Odometry>("synced_gnss");
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  nav_msgs::Odometry fix;
  fix.pose.pose.orientation.w = 1.0;
  fixes.publish(fix);
  live.publish(round_message(0));
  fix.pose.pose.position.x = 5.0;
  std::set<double> shown;
  const auto both_are_shown = [&] {
    for (const auto& message : markers.messages) {
      for (const auto& marker : message.markers) {
        if (marker.ns != "gnss") continue;
        for (const auto& point : marker.points) shown.insert(std::round(point.x - kEast));
      }
    }
    return shown.size() >= 2;
  };
  EXPECT_TRUE(send_until([&] { fixes.publish(fix); }, both_are_shown)) << node.output();
  EXPECT_EQ(shown, std::set<double>({0.0, 5.0}));
  ros::param::del("/run_state");
}

/// An empty grid says nothing.
TEST_F(MapViewerNode, SaysHowTheDriveGoesAndWhatToCallNext) {
  const NodeProcess node("map_viewer_node");
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  const auto shown = [&](const std::string& name, const std::string& text) {
    return std::any_of(markers.messages.begin(), markers.messages.end(), [&](const auto& message) {
      return std::any_of(message.markers.begin(), message.markers.end(), [&](const auto& marker) {
        return marker.ns == name && marker.text.find(text) != std::string::npos;
      });
    });
  };
  ASSERT_TRUE(wait_until([&] { return shown("status", "waiting for scans"); })) << node.output();
  const auto fixes = connected_publisher<nav_msgs::Odometry>("synced_gnss");
  const auto states = connected_publisher<FrontEndStatusMessage>("front_end_status");
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  nav_msgs::Odometry fix;
  fix.pose.pose.orientation.w = 1.0;
  fixes.publish(fix);
  FrontEndStatusMessage state;
  state.state = "degenerate";
  states.publish(state);
  live.publish(round_message(0));
  EXPECT_TRUE(wait_until([&] { return shown("status", "degenerate") && shown("gnss", ""); }))
      << node.output();
  EXPECT_TRUE(wait_until([&] { return shown("status", "/optimize_map"); })) << node.output();
  const auto poses = connected_publisher<KeyFramePosesMessage>("key_frame_poses");
  KeyFramePosesMessage answer = corrected(1, 1);
  answer.thorough = 1;
  poses.publish(answer);
  EXPECT_TRUE(wait_until([&] { return shown("status", "/save_map"); })) << node.output();
}

TEST_F(MapViewerNode, ShowsCandidatesThatMatchingDidNotAccept) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  ASSERT_TRUE(markers.wait_for(1)) << node.output();
  const auto verdicts = connected_publisher<LoopVerdictMessage>("loop_verdict");
  LoopVerdict verdict;
  for (const Verdict fate : {Verdict::kRefused, Verdict::kUndecided, Verdict::kAccepted}) {
    ++verdict.to;
    verdict.verdict = fate;
    verdicts.publish(ros_border::to_message(verdict, "run", "base_link"));
  }
  visualization_msgs::Marker candidates;
  const auto newest = [&] {
    for (const auto& message : markers.messages) {
      for (const auto& marker : message.markers) {
        if (marker.ns == "candidates") candidates = marker;
      }
    }
    return candidates;
  };
  ASSERT_TRUE(wait_until([&] { return newest().points.size() == 4; })) << node.output();
  EXPECT_LT(candidates.colors[0].g, 0.5F) << "refused: red";
  EXPECT_GT(candidates.colors[2].g, 0.5F) << "undecided: yellow";
}

/// As the back end tells a viewer that comes late of a long drive, or of a graph that turned over.
TEST_F(MapViewerNode, CountsAllLoopsThatAreJudgedAtOnce) {
  store(2);
  const NodeProcess node("map_viewer_node", {"_queue_size:=1"});
  ASSERT_TRUE(shows(2)) << node.output();
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  const auto verdicts = ros::NodeHandle().advertise<LoopVerdictMessage>("graph_verdict", 0);
  ASSERT_TRUE(wait_until([&] { return verdicts.getNumSubscribers() > 0; })) << node.output();
  constexpr KeyFrameIndex kLoops = 5000;
  LoopVerdict verdict;
  verdict.verdict = Verdict::kRefused;
  for (verdict.to = 1; verdict.to <= kLoops; ++verdict.to) {
    verdicts.publish(ros_border::to_message(verdict, "run", "base_link"));
  }
  const auto is_counted = [](const visualization_msgs::MarkerArray& message) {
    return std::any_of(message.markers.begin(), message.markers.end(), [](const auto& marker) {
      return marker.text.find("(5000 refused)") != std::string::npos;
    });
  };
  EXPECT_TRUE(wait_until([&] {
    return std::any_of(markers.messages.begin(), markers.messages.end(), is_counted);
  })) << node.output();
}

/// A key frame that was published while the viewer was connecting, and that none follows.
TEST_F(MapViewerNode, FetchesTheLastKeyFrameWhenThePosesNameIt) {
  store(kRound - 1);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kRound - 1)) << node.output();
  stored_.push_back(round_message(kRound - 1));
  const auto poses = connected_publisher<KeyFramePosesMessage>("key_frame_poses");
  poses.publish(corrected(kRound, 1));
  EXPECT_TRUE(shows(kRound)) << node.output();
}

/// One key frame of a message, as what moved since a revision.
KeyFramePosesMessage part_of(const KeyFramePosesMessage& all, std::size_t i, std::uint32_t since) {
  KeyFramePosesMessage part = all;
  part.whole = 0;
  part.since = since;
  part.revision = since + 1;
  part.indices = {all.indices[i]};
  part.stamps = {all.stamps[i]};
  part.poses = {all.poses[i]};
  return part;
}

TEST_F(MapViewerNode, TakesPosesThatMovedAndFetchesAllAfterALoss) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kRound)) << node.output();
  Listener<nav_msgs::Path> path("optimized_path");
  const auto shows_ends_at = [&](double first, double last) {
    return wait_until([&] {
      if (path.messages.empty() || path.messages.back().poses.size() != kRound) return false;
      const auto& shown = path.messages.back().poses;
      return std::abs(shown.front().pose.position.x - first) < 0.01 &&
             std::abs(shown.back().pose.position.x - last) < 0.01;
    });
  };
  const auto poses = connected_publisher<KeyFramePosesMessage>("key_frame_poses");
  poses_ = corrected(kRound, 1);
  poses.publish(poses_);
  EXPECT_TRUE(shows_ends_at(0.0, 0.0)) << node.output();
  poses_.poses.back().position.x = 3.0;
  poses.publish(part_of(poses_, kRound - 1, 1));
  EXPECT_TRUE(shows_ends_at(0.0, 3.0)) << node.output();
  // That of the last key frame is lost.
  poses_.poses.front().position.x = -4.0;
  poses_.poses.back().position.x = 5.0;
  poses_.revision = 4;
  poses.publish(part_of(poses_, 0, 3));
  EXPECT_TRUE(shows_ends_at(-4.0, 5.0)) << node.output();
}

// Without anything new the map is sent once.
TEST_F(MapViewerNode, AnIdleSystemSendsTheMapOnce) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kRound)) << node.output();
  Listener<sensor_msgs::PointCloud2> map("global_map");
  ASSERT_TRUE(map.wait_for(1)) << node.output();
  auto poses = ros::NodeHandle().advertise<KeyFramePosesMessage>("key_frame_poses", 10);
  wait_until([&] { return poses.getNumSubscribers() > 0; });
  poses.publish(corrected(kRound, 1));
  ASSERT_TRUE(map.wait_for(2)) << "poses moved";
  for (std::uint32_t revision = 2; revision < 5; ++revision) {
    poses.publish(corrected(kRound, revision));
  }
  EXPECT_FALSE(map.wait_for(3, 1.0)) << "they did not move again";
}

/// A solution each second that hardly moves anything would send the whole map each second.
TEST_F(MapViewerNode, ShowsSmallMovesAtTheIntervalOrIfTheMapWasOptimised) {
  store(kRound);
  for (const bool at_intervals : {true, false}) {
    const NodeProcess node("map_viewer_node", {std::string("_map_cloud_update_interval:=") +
                                               (at_intervals ? "2.0" : "3600.0")});
    ASSERT_TRUE(shows(kRound)) << node.output();
    Listener<sensor_msgs::PointCloud2> map("global_map");
    ASSERT_TRUE(map.wait_for(1)) << node.output();
    auto poses = ros::NodeHandle().advertise<KeyFramePosesMessage>("key_frame_poses", 10);
    wait_until([&] { return poses.getNumSubscribers() > 0; });
    poses.publish(corrected(kRound, 1));
    ASSERT_TRUE(map.wait_for(2)) << "poses moved by metres";
    KeyFramePosesMessage nudged = corrected(kRound, 2);
    for (auto& pose : nudged.poses) pose.position.x += 0.1;
    poses.publish(nudged);
    EXPECT_EQ(map.wait_for(3, at_intervals ? kPatience : 3.0), at_intervals) << node.output();
    if (at_intervals) continue;
    nudged.revision = 3;
    nudged.thorough = 1;
    poses.publish(nudged);
    EXPECT_TRUE(map.wait_for(3)) << node.output();
  }
}

/// As hdl_graph_slam has it: new key frames show once in an interval.
TEST_F(MapViewerNode, RefreshesTheMapAtIntervals) {
  for (const bool at_intervals : {true, false}) {
    const NodeProcess node("map_viewer_node", {std::string("_map_cloud_update_interval:=") +
                                               (at_intervals ? "2.0" : "3600.0")});
    Listener<sensor_msgs::PointCloud2> map("global_map");
    Listener<nav_msgs::Path> path("odom_path");
    const auto live = connected_publisher<KeyFrameMessage>("key_frame");
    ASSERT_TRUE(wait_until([&] { return map.connected() && path.connected(); }));
    for (int i = 0; i < 5; ++i) live.publish(round_message(i));
    EXPECT_EQ(map.wait_for(1, at_intervals ? kPatience : 3.0), at_intervals) << node.output();
    if (!at_intervals) continue;
    const auto points = map.messages.back().width * map.messages.back().height;
    for (int i = 5; i < 25; ++i) live.publish(round_message(i));
    EXPECT_TRUE(wait_until([&] {
      const auto& newest = map.messages.back();
      return newest.width * newest.height > points &&
             ros_border::from_ros(newest.header.stamp) == round_key_frame(24).stamp;
    })) << node.output();
    EXPECT_LE(map.messages.size(), 4U) << "a map per key frame would be 25";
    const std::size_t before = map.messages.size();
    EXPECT_FALSE(map.wait_for(before + 1, 3.0)) << "nothing new has come";
  }
}

/// Where the floor is and how old a key frame is, for who switches it on.
TEST_F(MapViewerNode, ShowsFloorsAndTheAgeOfKeyFrames) {
  const NodeProcess node("map_viewer_node");
  Listener<visualization_msgs::MarkerArray> markers("graph_markers");
  const auto floors = connected_publisher<FloorMessage>("floor");
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  ASSERT_TRUE(markers.wait_for(1)) << node.output();
  Floor floor;
  floor.stamp = round_key_frame(0).stamp;
  floor.found = true;
  floor.offset = 1.8;
  floors.publish(ros_border::to_message(floor, "base_link"));
  live.publish(round_message(0));
  const auto shown = [&](const std::string& name) {
    return std::any_of(markers.messages.begin(), markers.messages.end(), [&](const auto& message) {
      return std::any_of(message.markers.begin(), message.markers.end(), [&](const auto& marker) {
        return marker.ns == name && !marker.points.empty();
      });
    });
  };
  EXPECT_TRUE(wait_until([&] { return shown("floors") && shown("age"); })) << node.output();
}

}  // namespace
}  // namespace lidar_mapping::test
