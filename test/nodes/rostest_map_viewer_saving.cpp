// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>

#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/run_state.hpp"
#include "lidar_mapping/session/session.hpp"

#include "file_content.hpp"
#include "listener.hpp"
#include "map_viewer_fixture.hpp"
#include "node_process.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;

/// Ground and a wall all round, seen from one place; key frame 3 sees a box before the wall as
/// well.
KeyFrameMessage standing_message(int index) {
  auto cloud = std::make_shared<PointCloud>();
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      cloud->points.push_back({0.25F * static_cast<float>(i), 0.25F * static_cast<float>(j), 0, 1});
    }
  }
  for (int i = 0; i < 1800; ++i) {
    const float azimuth = static_cast<float>(i) * 3.14159265F / 900.0F;
    for (float z = 0.0F; z < 4.0F; z += 0.1F) {
      cloud->points.push_back({15.0F * std::cos(azimuth), 15.0F * std::sin(azimuth), z, 1});
    }
  }
  for (int i = 0; index == 3 && i < 100; ++i) {
    const auto column = static_cast<float>(i % 10);
    const auto row = static_cast<float>(i / 10);
    cloud->points.push_back({5.0F, 0.1F * column, 0.7F + 0.1F * row, 1});
  }
  KeyFrame key_frame;
  key_frame.index = static_cast<KeyFrameIndex>(index);
  key_frame.stamp = round_key_frame(index).stamp;
  key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
  key_frame.cloud = cloud;
  return ros_border::to_message(key_frame, "run", "base_link");
}

/// Points of the box that only one key frame saw.
std::ptrdiff_t points_of_box(const fs::path& pcd) {
  const PointCloud map = session::read_pcd(pcd);
  return std::count_if(map.points.begin(), map.points.end(),
                       [](const Point& p) { return p.z > 0.5F && std::hypot(p.x, p.y) < 8.0F; });
}

TEST_F(MapViewerNode, SavesKeyFramesThatOnlyTheBackEndHas) {
  store(kRound - 1);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kRound - 1)) << node.output();
  stored_.push_back(round_message(kRound - 1));
  const SaveMap::Response answer = save(folder_.path() / "map", {"pcd"});
  EXPECT_NE(answer.message.find("of " + std::to_string(kRound) + " key frames"), std::string::npos)
      << answer.message << node.output();
}

/// As hdl_graph_slam's save_map: file name, UTM and resolution.
TEST_F(MapViewerNode, SavesOneNewFileInUtm) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  const auto datum = ros::NodeHandle().advertise<sensor_msgs::NavSatFix>("gnss_datum", 1, true);
  ASSERT_TRUE(shows(kRound)) << node.output();
  SaveMap call;
  call.request.destination = (folder_.path() / "town.pcd").string();
  call.request.utm = true;
  call.request.resolution = 0.5;
  SaveMap::Response answer = save(call);
  EXPECT_FALSE(answer.success);
  EXPECT_NE(answer.message.find("there was no GNSS"), std::string::npos) << answer.message;
  sensor_msgs::NavSatFix fix;
  fix.latitude = 49.0;
  fix.longitude = 8.4;
  fix.altitude = 110.0;
  datum.publish(fix);
  ASSERT_TRUE(wait_until([&] {
    answer = save(call);
    return answer.success;
  })) << answer.message;
  EXPECT_EQ(answer.files.size(), 3U);
  for (const char* name : {"town.pcd", "town.pcd.utm", "town.yaml"}) {
    EXPECT_TRUE(fs::exists(folder_.path() / name)) << name;
  }
  EXPECT_FALSE(fs::exists(folder_.path() / "town.ply"));
  call.request.destination = (folder_.path() / "fine.pcd").string();
  call.request.resolution = 0.1;
  answer = save(call);
  EXPECT_TRUE(answer.success) << answer.message;
  const auto points = [&](const char* name) {
    return static_cast<double>(session::read_pcd(folder_.path() / name).size());
  };
  EXPECT_LT(points("town.pcd"), 0.75 * points("fine.pcd")) << "voxels of 0.5 m and of 0.1 m";
  call.request.destination = (folder_.path() / "town.pcd").string();
  answer = save(call);
  EXPECT_FALSE(answer.success);
  EXPECT_NE(answer.message.find("is there already"), std::string::npos) << answer.message;
  // A session that is gone on with keeps the datum of its first drive.
  {
    auto first = session::Session::create_in(folder_.path() / "session");
    first.set_run_id("run");
    first.set_datum({10.0, 20.0, 30.0});
    first.set_poses(KeyFramePoses{}, {}, true);
  }
  ros::NodeHandle().setParam(ros_border::kRunSession, (folder_.path() / "session").string());
  call.request.destination = (folder_.path() / "first.pcd").string();
  answer = save(call);
  ros::NodeHandle().deleteParam(ros_border::kRunSession);
  EXPECT_TRUE(answer.success) << answer.message;
  const std::string yaml = content_of(folder_.path() / "first.yaml");
  EXPECT_NE(yaml.find("latitude: 10.0"), std::string::npos) << yaml;
}

/// As where the back end writes its session on another machine.
TEST_F(MapViewerNode, SaysWhyItSavesWithoutTheSession) {
  store(3);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(3)) << node.output();
  ros::NodeHandle().setParam(ros_border::kRunSession, (folder_.path() / "nothing").string());
  const SaveMap::Response answer = save(folder_.path() / "map", {"pcd"});
  ros::NodeHandle().deleteParam(ros_border::kRunSession);
  EXPECT_TRUE(answer.success) << answer.message;
  EXPECT_TRUE(wait_until([&] {
    return node.says("saved without what the session knows: there is no session in");
  })) << node.output();
}

// A master that goes on keeps the parameters of earlier nodes: their map was overwritten.
TEST_F(MapViewerNode, LeavesTheSessionOfAnotherRunAlone) {
  store(3);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(3)) << node.output();
  const fs::path session = folder_.path() / "session";
  session::Session::create_in(session).set_run_id("yesterday");
  SaveMap call;
  call.request.formats = {"pcd"};
  ros::NodeHandle().setParam("session_folder", session.string());
  const SaveMap::Response stale = save(call);
  ros::NodeHandle().deleteParam("session_folder");
  EXPECT_FALSE(stale.success);
  EXPECT_NE(stale.message.find("the back end has no session"), std::string::npos) << stale.message;
  ros::NodeHandle().setParam(ros_border::kRunSession, session.string());
  const SaveMap::Response refused = save(call);
  const SaveMap::Response elsewhere = save(folder_.path() / "map", {"pcd"});
  ros::NodeHandle().deleteParam(ros_border::kRunSession);
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("is that of run 'yesterday'"), std::string::npos)
      << refused.message;
  EXPECT_FALSE(fs::exists(session / "map"));
  EXPECT_TRUE(elsewhere.success) << elsewhere.message;
  EXPECT_TRUE(wait_until([&] {
    return node.says("saved without what the session knows: the session " + session.string());
  })) << node.output();
}

// What moved while it was seen is not in the map, unless it is wanted or nobody knows whence.
TEST_F(MapViewerNode, SavesTheMapWithoutMovingObjects) {
  constexpr int kStanding = 8;
  for (int i = 0; i < kStanding; ++i) stored_.push_back(standing_message(i));
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kStanding)) << node.output();
  const SaveMap::Response unknown = save(folder_.path() / "unknown", {"pcd"});
  EXPECT_NE(unknown.message.find("moving objects"), std::string::npos) << unknown.message;
  EXPECT_GT(points_of_box(folder_.path() / "unknown/map.pcd"), 10);
  {
    auto session = session::Session::create_in(folder_.path() / "session");
    session.set_run_id("run");
    session.set_sensor_origin({0.0, 0.0, 1.8});
  }
  ros::NodeHandle().setParam(ros_border::kRunSession, (folder_.path() / "session").string());
  const SaveMap::Response removed = save(folder_.path() / "removed", {"pcd"});
  const SaveMap::Response kept = save(folder_.path() / "kept", {"pcd"}, true);
  ros::NodeHandle().deleteParam(ros_border::kRunSession);
  EXPECT_TRUE(removed.success) << removed.message << node.output();
  EXPECT_EQ(removed.message.find("moving objects"), std::string::npos) << removed.message;
  EXPECT_EQ(points_of_box(folder_.path() / "removed/map.pcd"), 0);
  EXPECT_GT(points_of_box(folder_.path() / "kept/map.pcd"), 10);
}

// Saving works without an optimisation, and says what it wrote.
TEST_F(MapViewerNode, SavesTheMapAndNamesTheFiles) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kRound)) << node.output();
  const SaveMap::Response answer = save(folder_.path() / "map", {"pcd"});
  EXPECT_TRUE(answer.success) << answer.message << node.output();
  ASSERT_EQ(answer.files.size(), 2U);
  for (const std::string& file : answer.files) EXPECT_TRUE(fs::exists(file)) << file;

  const PointCloud whole = session::read_pcd(folder_.path() / "map" / "map.pcd");
  ASSERT_GT(whole.size(), 100U);
  const double x = static_cast<double>(whole.points[whole.size() / 2].x);
  const SaveMap::Response half =
      save(folder_.path() / "half", {"PCD"}, false, 0.0, {-1e4, -1e4, -1e4, x, 1e4, 1e4});
  EXPECT_TRUE(half.success) << half.message;
  const PointCloud part = session::read_pcd(folder_.path() / "half" / "map.pcd");
  EXPECT_LT(part.size(), whole.size());
  for (const Point& point : part.points) ASSERT_LE(static_cast<double>(point.x), x + 1e-3);
  EXPECT_NE(save(folder_.path(), {"pcd"}, false, 0.0, {1, 2, 3}).message.find("six numbers"),
            std::string::npos);
}

// It wrote to a folder of the name ~ below the node's working directory.
TEST_F(MapViewerNode, SavesToTheHomeFolderAndSaysWhere) {
  store(kRound);
  const std::string before = std::getenv("HOME") != nullptr ? std::getenv("HOME") : "";
  setenv("HOME", folder_.path().c_str(), 1);
  const NodeProcess node("map_viewer_node");
  setenv("HOME", before.c_str(), 1);
  ASSERT_TRUE(shows(kRound)) << node.output();
  const SaveMap::Response answer = save("~/maps", {"pcd"});
  EXPECT_TRUE(answer.success) << answer.message << node.output();
  const std::string place = (folder_.path() / "maps").string();
  EXPECT_NE(answer.message.find("written to " + place), std::string::npos) << answer.message;
  EXPECT_TRUE(fs::exists(folder_.path() / "maps/map.pcd"));
  EXPECT_NE(save("~nobody/maps", {"pcd"}).message.find("give the whole path"), std::string::npos);
}

// The same products as build_map makes of the session.
TEST_F(MapViewerNode, SavesEveryFormat) {
  store(kRound);
  const NodeProcess node("map_viewer_node");
  ASSERT_TRUE(shows(kRound)) << node.output();
  // Without a session nobody knows where the LiDAR is, so nothing tells what has changed.
  std::vector<std::string> formats = map::product_formats();
  formats.erase(std::find(formats.begin(), formats.end(), "changes"));
  const SaveMap::Response changes = save(folder_.path() / "changes", {"changes"});
  EXPECT_FALSE(changes.success);
  EXPECT_NE(changes.message.find("give its position in base_link"), std::string::npos)
      << changes.message;
  const SaveMap::Response answer = save(folder_.path() / "map", formats);
  EXPECT_TRUE(answer.success) << answer.message << node.output();
  for (const char* file : {"map.yaml", "map.pcd", "map.ply", "top_view.png", "map.las",
                           "pointcloud_map/pointcloud_map_metadata.yaml", "grid.pgm"}) {
    EXPECT_TRUE(fs::exists(folder_.path() / "map" / file)) << file;
  }
}

// Each thing that cannot be done has its own message.
TEST_F(MapViewerNode, SaysWhyItCannotSave) {
  ros::param::del(ros_border::kRunSession);
  const NodeProcess node("map_viewer_node");
  const SaveMap::Response empty = save(folder_.path());
  EXPECT_FALSE(empty.success);
  EXPECT_NE(empty.message.find("no key frames"), std::string::npos) << empty.message;
  const auto live = connected_publisher<KeyFrameMessage>("key_frame");
  live.publish(round_message(0));
  ASSERT_TRUE(shows(1)) << node.output();
  EXPECT_NE(save("").message.find("name a directory"), std::string::npos);
  EXPECT_NE(save(folder_.path(), {"doc"}).message.find("not known"), std::string::npos);
  const SaveMap::Response nowhere = save("/proc/nowhere", {"pcd"});
  EXPECT_FALSE(nowhere.success);
  EXPECT_NE(nowhere.message.find("/proc/nowhere"), std::string::npos) << nowhere.message;
  const SaveMap::Response fine = save(folder_.path(), {"pcd"}, false, -0.1);
  EXPECT_NE(fine.message.find("allowed: real number from 0.01"), std::string::npos) << fine.message;
}

}  // namespace
}  // namespace lidar_mapping::test
