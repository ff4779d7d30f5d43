// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include "mapped_drive.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::content_of;
using test::Program;
using test::TemporaryFolder;
using test::Words;

/// Short drives through the command itself.
class MapBag : public test::MappedDrive {};

TEST_F(MapBag, MakesASessionAndItsMap) {
  for (const char* name : {"session.db", "config.yaml", "trajectory/optimized.tum", "map/map.pcd",
                           "map/map.yaml", "graph.g2o", "key_frames/000000.pcd", "doubt.csv"}) {
    EXPECT_TRUE(fs::exists(whole() / name)) << name;
  }
  EXPECT_GT(Session::open(whole(), Session::Access::kRead).key_frame_count(), 10U);
}

TEST_F(MapBag, MapsBagsWithoutTransformsAndStamps) {
  const TemporaryFolder folder;
  const std::string bag = folder.path() / "plain.bag";
  ASSERT_EQ(Program("simulate_drive",
                    {bag, "--lidar", "vlp16", "--duration", "8", "--fault", "no_transforms",
                     "--fault", "no_stamps"},
                    root() / "log")
                .wait(),
            0)
      << said();
  const std::string session = folder.path() / "session";
  EXPECT_EQ(Program("map_bag", {bag, "-o", session, "--no-map"}, root() / "log").wait(), 0);
  EXPECT_TRUE(has_said("the recording has no transform from 'velo_link' to 'base_link'")) << said();
  EXPECT_TRUE(has_said("map_bag takes the times of their recording"));
  EXPECT_GT(Session::open(session, Session::Access::kRead).key_frame_count(), 2U);
}

TEST_F(MapBag, LeavesAFolderAloneThatIsNotEmpty) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "diary.txt") << "mine";
  EXPECT_EQ(map({"-o", folder.path().string()}), 1);
  EXPECT_TRUE(has_said("is not empty")) << said();
  EXPECT_TRUE(has_said("--resume"));
  EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST_F(MapBag, ReadsFoldersOfKittiAndKittiToBagWritesThem) {
  const TemporaryFolder parent;
  const fs::path odometry = parent.path() / "odometry";
  const fs::path raw = parent.path() / "raw";
  ASSERT_EQ(run("simulate_drive", {"--kitti", odometry, "--lidar", "vlp16", "--duration", "4"}), 0);
  EXPECT_EQ(run("map_bag", {odometry, "-o", parent.path() / "a", "--no-map"}), 0) << said();
  fs::create_directories(raw / "velodyne_points");
  fs::rename(odometry / "velodyne", raw / "velodyne_points" / "data");
  std::ofstream dates(raw / "velodyne_points" / "timestamps.txt");
  for (int i = 0; i < 60; ++i) dates << "2011-09-26 13:02:2" << i / 10 << "." << i % 10 << "\n";
  dates.close();
  const fs::path written = parent.path() / "raw.bag";
  ASSERT_EQ(run("kitti_to_bag", {raw, written}), 0) << said();
  const auto count = [&](const std::string& input, const std::string& output) {
    EXPECT_EQ(run("map_bag", {input, "-o", parent.path() / output, "--no-map"}), 0) << said();
    return Session::open(parent.path() / output, Session::Access::kRead).scans().size();
  };
  const std::size_t scans = files_in(raw / "velodyne_points" / "data");
  EXPECT_GT(scans, 20U);
  EXPECT_EQ(count(raw, "b"), scans);
  EXPECT_EQ(count(written, "c"), scans);
}

TEST_F(MapBag, MapsWhatIsNotDamaged) {
  const fs::path damaged = root() / "damaged.bag";
  fs::copy_file(bag(), damaged);
  std::fstream file(damaged, std::ios::in | std::ios::out | std::ios::binary);
  for (const std::uintmax_t part : {5, 2}) {  // in the first seconds, which are looked at, too
    file.seekp(static_cast<std::streamoff>(fs::file_size(damaged) / part));
    file << std::string(20'000, '\xFF');
  }
  file.close();
  Program program("map_bag", {damaged.string(), "-o", (root() / "rest").string(), "--no-map"},
                  root() / "log");
  ASSERT_EQ(program.wait(), 0) << said();
  EXPECT_TRUE(has_said("is left out")) << said();
  const auto key_frames = [](const fs::path& folder) {
    return Session::open(folder, Session::Access::kRead).key_frame_count();
  };
  EXPECT_GE(key_frames(root() / "rest") + 4, key_frames(whole()));
}

TEST_F(MapBag, SaysWhichTopicIsMissing) {
  const TemporaryFolder parent;
  EXPECT_EQ(map({"-o", (parent.path() / "s").string(), "--points", "/no/such"}), 1);
  EXPECT_TRUE(has_said("/no/such")) << said();
  EXPECT_FALSE(fs::exists(parent.path() / "s"));
}

TEST_F(MapBag, TakesTheNameOfASensorAndListsThemWhereItIsUnknown) {
  const TemporaryFolder parent;
  EXPECT_EQ(map({"-o", (parent.path() / "s").string(), "--sensor", "vlp61"}), 1);
  EXPECT_TRUE(has_said("vlp61")) << said();
  for (const auto& sensor : fs::directory_iterator("../config/sensors")) {
    EXPECT_TRUE(has_said(sensor.path().stem().string())) << sensor.path() << said();
  }
  EXPECT_EQ(map({"-o", (parent.path() / "s").string(), "--sensor", "vlp16", "--no-map"}), 0)
      << said();
}

TEST_F(MapBag, MapsThePartThatIsWanted) {
  const TemporaryFolder parent;
  const fs::path folder = parent.path() / "part";
  ASSERT_EQ(map({"-o", folder, "--start", "4", "--duration", "6", "--no-map"}), 0) << said();
  const auto all = Session::open(whole(), Session::Access::kRead).scans();
  const auto scans = Session::open(folder, Session::Access::kRead).scans();
  const double after = to_seconds(scans.front().stamp - all.front().stamp);
  EXPECT_NEAR(after, 4.0, 0.5);
  EXPECT_NEAR(to_seconds(scans.back().stamp - scans.front().stamp), 6.0, 0.5);
  EXPECT_EQ(map({"-o", parent.path() / "none", "--start", "400"}), 1);
  EXPECT_TRUE(has_said("--start 400")) << said();
}

TEST_F(MapBag, TakesSingleParameters) {
  const TemporaryFolder parent;
  const fs::path folder = parent.path() / "s";
  ASSERT_EQ(
      map({"-o", folder, "--no-map", "--duration", "3", "--parameter", "back_end/use_gnss: false",
           "--parameter", "front_end: {key_frame_distance: 3, registration_method: NDT_OMP}",
           "--parameter", "loop_closing/registration_method: FAST_GICP"}),
      0)
      << said();
  EXPECT_TRUE(has_said("odometry: registration_method NDT_OMP is hdl_graph_slam's")) << said();
  EXPECT_TRUE(has_said("loops: registration_method FAST_GICP is hdl_graph_slam's")) << said();
  const std::string in_force = content_of(folder / "config.yaml");
  EXPECT_NE(in_force.find("use_gnss: false"), std::string::npos);
  EXPECT_NE(in_force.find("key_frame_distance: 3"), std::string::npos);
}

TEST_F(MapBag, TakesAFolderOfBags) {
  const TemporaryFolder parent;
  fs::create_directory(parent.path() / "bags");
  fs::create_hard_link(bag(), parent.path() / "bags" / "drive_0.bag");
  std::ofstream(parent.path() / "bags" / "notes.txt") << "a fine day";
  const fs::path folder = parent.path() / "s";
  EXPECT_EQ(run("map_bag", {parent.path() / "bags", "-o", folder, "--no-map", "--duration", "3"}),
            0)
      << said();
  EXPECT_GT(key_frames_in(folder), 0U);
  EXPECT_LE(run("check_bag", {parent.path() / "bags"}), 1) << said();  // 2: it cannot be read
  EXPECT_TRUE(has_said("/kitti/velo/pointcloud")) << said();
}

/// A simulated tunnel with the time around it, by the LiDAR alone but for a measured velocity.
class MapBagInATunnel : public MapBag {
 protected:
  static fs::path tunnel() {
    const fs::path bag = root() / "tunnel.bag";
    if (!fs::exists(bag)) {
      EXPECT_EQ(run("simulate_drive", {bag, "--drive", "tunnel", "--lidar", "vlp16", "--start", "8",
                                       "--duration", "48", "--no-imu", "--no-gnss"}),
                0)
          << said();
    }
    return bag;
  }
  static int map_tunnel(const fs::path& session, const Words& more) {
    return map_tunnel(tunnel(), session, more);
  }
  static int map_tunnel(const fs::path& bag, const fs::path& session, const Words& more) {
    Words words = {bag, "-o", session, "--no-map"};
    words.insert(words.end(), more.begin(), more.end());
    return run("map_bag", words);
  }
};

/// The same recording, in which a wheel odometry in tf stands for the topic of the velocity.
void write_with_wheels(const fs::path& from, const fs::path& to) {
  rosbag::Bag source(from.string(), rosbag::bagmode::Read);
  rosbag::Bag target(to.string(), rosbag::bagmode::Write);
  for (const rosbag::MessageInstance& message : rosbag::View(source)) {
    if (message.getTopic() == "/kitti/oxts/gps/vel") continue;
    if (const auto truth = message.instantiate<nav_msgs::Odometry>()) {
      tf2_msgs::TFMessage wheels;
      wheels.transforms.resize(1);
      geometry_msgs::TransformStamped& transform = wheels.transforms[0];
      transform.header = truth->header;
      transform.header.frame_id = "wheels";
      transform.child_frame_id = "base_link";
      transform.transform.translation.x = truth->pose.pose.position.x;
      transform.transform.translation.y = truth->pose.pose.position.y;
      transform.transform.translation.z = truth->pose.pose.position.z;
      transform.transform.rotation = truth->pose.pose.orientation;
      target.write("/tf", message.getTime(), wheels);
    } else {
      target.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
    }
  }
}

TEST_F(MapBagInATunnel, SaysWhereAMapCannotBeTrusted) {
  const TemporaryFolder parent;
  const fs::path session = parent.path() / "s";
  const Words alone = {"--parameter", "preprocessing/use_velocity: false"};
  EXPECT_EQ(map_tunnel(session, alone), 4) << said();
  EXPECT_TRUE(has_said("Do not trust this map between")) << said();
  EXPECT_NE(content_of(session / "doubt.csv").find("\ndegenerate,"), std::string::npos);
  // Neither a second look at a session that is complete nor its report is kinder.
  Words again = alone;
  again.emplace_back("--resume");
  EXPECT_EQ(map_tunnel(session, again), 4) << said();
  again.emplace_back("--allow-doubt");
  EXPECT_EQ(map_tunnel(session, again), 0) << said();
  EXPECT_TRUE(has_said("Do not trust this map between")) << said();
  EXPECT_EQ(run("map_quality", {session, "--report"}), 0) << said();
  EXPECT_TRUE(has_said("Do not trust this map between")) << said();
  EXPECT_TRUE(has_said("Motion observed")) << said();
  EXPECT_FALSE(has_said("Good: ")) << said();
  EXPECT_NE(content_of(session / "report.html").find("Do not trust this map between"),
            std::string::npos);
}

TEST_F(MapBagInATunnel, TrustsAMapWhoseSpeedWasMeasured) {
  const TemporaryFolder parent;
  EXPECT_EQ(map_tunnel(parent.path() / "s", {}), 0) << said();
  EXPECT_FALSE(has_said("Do not trust")) << said();
}

TEST_F(MapBagInATunnel, TakesTheSpeedFromAWheelOdometryInTf) {
  const TemporaryFolder parent;
  const fs::path bag = parent.path() / "wheels.bag";
  write_with_wheels(tunnel(), bag);
  EXPECT_EQ(map_tunnel(bag, parent.path() / "without", {}), 4) << said();
  EXPECT_EQ(map_tunnel(bag, parent.path() / "with",
                       {"--parameter",
                        "preprocessing: {enable_robot_odometry_init_guess: true, "
                        "robot_odom_frame_id: wheels}"}),
            0)
      << said();
}

// A shell would end the first word at the quote, and the next at the space.
TEST_F(MapBag, ReportsInFoldersOfAnyName) {
  const TemporaryFolder parent;
  const fs::path folder = parent.path() / "Rock 'n' Roll $HOME";
  EXPECT_EQ(map({"-o", folder, "--no-map", "--duration", "4", "--report"}), 0) << said();
  EXPECT_TRUE(fs::exists(folder / "report.html")) << said();
  EXPECT_NE(content_of(folder / "report.html").find("drive.bag"), std::string::npos);
}

}  // namespace
}  // namespace lidar_mapping::tools
