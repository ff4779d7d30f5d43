// SPDX-License-Identifier: BSD-3-Clause

#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "mapped_drive.hpp"
#include "rewritten_bag.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::holds;
using test::Words;

/// Short drives through the command itself.
class MapBag : public test::MappedDrive {};

TEST_F(MapBag, MakesASessionAndItsMap) {
  for (const char* name : {"session.db", "config.yaml", "trajectory/optimized.tum", "map/map.pcd",
                           "map/map.yaml", "graph.g2o", "key_frames/000000.pcd", "doubt.csv"}) {
    EXPECT_TRUE(fs::exists(whole() / name)) << name;
  }
  EXPECT_GT(key_frames_in(whole()), 10U);
}

TEST_F(MapBag, MapsBagsWithoutTransformsAndStamps) {
  const std::string bag = folder_.path() / "plain.bag";
  ASSERT_EQ(run("simulate_drive", {bag, "--lidar", "vlp16", "--duration", "8", "--fault",
                                   "no_transforms", "--fault", "no_stamps"}),
            0);
  const std::string session = folder_.path() / "session";
  EXPECT_EQ(run("map_bag", {bag, "-o", session, "--no-map"}), 0);
  EXPECT_TRUE(has_said("the recording has no transform from 'velo_link' to 'base_link'"));
  EXPECT_TRUE(has_said("map_bag takes the times of their recording"));
  EXPECT_GT(key_frames_in(session), 2U);
}

TEST_F(MapBag, LeavesAFolderAloneThatIsNotEmpty) {
  std::ofstream(folder_.path() / "diary.txt") << "mine";
  EXPECT_EQ(map({"-o", folder_.path()}), 1);
  EXPECT_TRUE(has_said("is not empty"));
  EXPECT_TRUE(has_said("--resume"));
  EXPECT_EQ(files_in(folder_.path()), 1U);
}

TEST_F(MapBag, ReadsFoldersOfKittiAndKittiToBagWritesThem) {
  const fs::path odometry = folder_.path() / "odometry";
  const fs::path raw = folder_.path() / "raw";
  ASSERT_EQ(run("simulate_drive", {"--kitti", odometry, "--lidar", "vlp16", "--duration", "4"}), 0);
  EXPECT_EQ(run("map_bag", {odometry, "-o", folder_.path() / "a", "--no-map"}), 0);
  fs::create_directories(raw / "velodyne_points");
  fs::rename(odometry / "velodyne", raw / "velodyne_points" / "data");
  std::ofstream dates(raw / "velodyne_points" / "timestamps.txt");
  for (int i = 0; i < 60; ++i) dates << "2011-09-26 13:02:2" << i / 10 << "." << i % 10 << "\n";
  dates.close();
  const fs::path written = folder_.path() / "raw.bag";
  ASSERT_EQ(run("kitti_to_bag", {raw, written}), 0);
  const auto count = [&](const std::string& input, const std::string& output) {
    EXPECT_EQ(run("map_bag", {input, "-o", folder_.path() / output, "--no-map"}), 0);
    return opened(folder_.path() / output).scans().size();
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
  ASSERT_EQ(run("map_bag", {damaged, "-o", root() / "rest", "--no-map"}), 0);
  EXPECT_TRUE(has_said("is left out"));
  EXPECT_GE(key_frames_in(root() / "rest") + 4, key_frames_in(whole()));
}

TEST_F(MapBag, SaysWhichTopicIsMissing) {
  EXPECT_EQ(map({"-o", folder_.path() / "s", "--points", "/no/such"}), 1);
  EXPECT_TRUE(has_said("/no/such"));
  EXPECT_FALSE(fs::exists(folder_.path() / "s"));
}

TEST_F(MapBag, TakesTheNameOfASensorAndListsThemWhereItIsUnknown) {
  EXPECT_EQ(map({"-o", folder_.path() / "s", "--sensor", "vlp61"}), 1);
  EXPECT_TRUE(has_said("vlp61"));
  for (const auto& sensor : fs::directory_iterator("../config/sensors")) {
    EXPECT_TRUE(has_said(sensor.path().stem()));
  }
  EXPECT_EQ(map({"-o", folder_.path() / "s", "--sensor", "vlp16", "--no-map"}), 0);
}

TEST_F(MapBag, MapsThePartThatIsWanted) {
  const fs::path folder = folder_.path() / "part";
  ASSERT_EQ(map({"-o", folder, "--start", "4", "--duration", "6", "--no-map"}), 0);
  const auto all = opened(whole()).scans();
  const auto scans = opened(folder).scans();
  const double after = to_seconds(scans.front().stamp - all.front().stamp);
  EXPECT_NEAR(after, 4.0, 0.5);
  EXPECT_NEAR(to_seconds(scans.back().stamp - scans.front().stamp), 6.0, 0.5);
  EXPECT_EQ(map({"-o", folder_.path() / "none", "--start", "400"}), 1);
  EXPECT_TRUE(has_said("--start 400"));
}

TEST_F(MapBag, TakesSingleParameters) {
  const fs::path folder = folder_.path() / "s";
  ASSERT_EQ(
      map({"-o", folder, "--no-map", "--duration", "3", "--parameter", "back_end/use_gnss: false",
           "--parameter", "front_end: {key_frame_distance: 3, registration_method: NDT_OMP}",
           "--parameter", "loop_closing/registration_method: FAST_GICP"}),
      0);
  EXPECT_TRUE(has_said("odometry: registration_method NDT_OMP is hdl_graph_slam's"));
  EXPECT_TRUE(has_said("loops: registration_method FAST_GICP is hdl_graph_slam's"));
  const std::string in_force = content_of(folder / "config.yaml");
  EXPECT_TRUE(holds(in_force, "use_gnss: false"));
  EXPECT_TRUE(holds(in_force, "key_frame_distance: 3"));
}

TEST_F(MapBag, TakesParametersThatCheckBagJudgesBy) {
  const std::string bag = folder_.path() / "imu_in_g.bag",
                    front_end = folder_.path() / "front_end.yaml";
  ASSERT_EQ(
      run("simulate_drive", {bag, "--lidar", "vlp16", "--duration", "8", "--fault", "imu_in_g"}),
      0);
  EXPECT_EQ(run("check_bag", {bag}), 1);
  EXPECT_TRUE(has_said("remedy: set imu_acceleration_unit to G"));
  const Words remedy = {"--parameter", "preprocessing/imu_acceleration_unit: G"};
  EXPECT_EQ(run("check_bag", joined({bag, "--sensor", "vlp16"}, remedy)), 0);
  std::ofstream(front_end) << "key_frame_distance: 3\n";
  EXPECT_EQ(run("check_bag", joined({bag, "--config", front_end}, remedy)), 0)
      << "it says nothing about preprocessing";
}

TEST_F(MapBag, TakesAFolderOfBags) {
  fs::create_directory(folder_.path() / "bags");
  fs::create_hard_link(bag(), folder_.path() / "bags" / "drive_0.bag");
  std::ofstream(folder_.path() / "bags" / "notes.txt") << "a fine day";
  const fs::path folder = folder_.path() / "s";
  EXPECT_EQ(run("map_bag", {folder_.path() / "bags", "-o", folder, "--no-map", "--duration", "3"}),
            0);
  EXPECT_GT(key_frames_in(folder), 0U);
  EXPECT_LE(run("check_bag", {folder_.path() / "bags"}), 1);  // 2: it cannot be read
  EXPECT_TRUE(has_said("/kitti/velo/pointcloud"));
}

/// A simulated tunnel with the time around it, by the LiDAR alone but for a measured velocity.
class MapBagInATunnel : public MapBag {
 protected:
  static fs::path tunnel() {
    const fs::path bag = root() / "tunnel.bag";
    if (!fs::exists(bag)) {
      EXPECT_EQ(run("simulate_drive", {bag, "--drive", "tunnel", "--lidar", "vlp16", "--start", "8",
                                       "--duration", "48", "--no-imu", "--no-gnss"}),
                0);
    }
    return bag;
  }
  static test::Ending map_tunnel(const fs::path& session, const Words& more) {
    return map_tunnel(tunnel(), session, more);
  }
  static test::Ending map_tunnel(const fs::path& bag, const fs::path& session, const Words& more) {
    return run("map_bag", joined({bag, "-o", session, "--no-map"}, more));
  }
};

/// The same recording, in which a wheel odometry in tf stands for the topic of the velocity.
void write_with_wheels(const fs::path& from, const fs::path& to) {
  test::rewrite_bag(from, to, [](rosbag::Bag& target, const rosbag::MessageInstance& message) {
    if (message.getTopic() == "/kitti/oxts/gps/vel") return true;
    const auto truth = message.instantiate<nav_msgs::Odometry>();
    if (!truth) return false;
    tf2_msgs::TFMessage wheels;
    wheels.transforms = {ros_border::stamped_transform(ros_border::from_message(truth->pose.pose),
                                                       ros_border::from_ros(truth->header.stamp),
                                                       "wheels", "base_link")};
    target.write("/tf", message.getTime(), wheels);
    return true;
  });
}

TEST_F(MapBagInATunnel, SaysWhereAMapCannotBeTrusted) {
  const fs::path session = folder_.path() / "s";
  const Words alone = {"--parameter", "preprocessing/use_velocity: false"};
  EXPECT_EQ(map_tunnel(session, alone), 4);
  EXPECT_TRUE(has_said("Do not trust this map between"));
  EXPECT_TRUE(holds(content_of(session / "doubt.csv"), "\ndegenerate,"));
  // Neither a second look at a session that is complete nor its report is kinder.
  Words again = alone;
  again.emplace_back("--resume");
  EXPECT_EQ(map_tunnel(session, again), 4);
  again.emplace_back("--allow-doubt");
  EXPECT_EQ(map_tunnel(session, again), 0);
  EXPECT_TRUE(has_said("Do not trust this map between"));
  EXPECT_EQ(run("map_quality", {session, "--report"}), 0);
  EXPECT_TRUE(has_said("Do not trust this map between"));
  EXPECT_TRUE(has_said("Motion observed"));
  EXPECT_FALSE(has_said("Good: "));
  EXPECT_TRUE(holds(content_of(session / "report.html"), "Do not trust this map between"));
}

TEST_F(MapBagInATunnel, TrustsAMapWhoseSpeedWasMeasured) {
  EXPECT_EQ(map_tunnel(folder_.path() / "s", {}), 0);
  EXPECT_FALSE(has_said("Do not trust"));
}

TEST_F(MapBagInATunnel, TakesTheSpeedFromAWheelOdometryInTf) {
  const fs::path bag = folder_.path() / "wheels.bag";
  write_with_wheels(tunnel(), bag);
  EXPECT_EQ(map_tunnel(bag, folder_.path() / "without", {}), 4);
  EXPECT_EQ(map_tunnel(bag, folder_.path() / "with",
                       {"--parameter",
                        "preprocessing: {enable_robot_odometry_init_guess: true, "
                        "robot_odom_frame_id: wheels}"}),
            0);
}

// A shell would end the first word at the quote, and the next at the space.
TEST_F(MapBag, ReportsInFoldersOfAnyName) {
  const fs::path folder = folder_.path() / "Rock 'n' Roll $HOME";
  EXPECT_EQ(map({"-o", folder, "--no-map", "--duration", "4", "--report"}), 0);
  EXPECT_TRUE(fs::exists(folder / "report.html")) << said();
  EXPECT_TRUE(holds(content_of(folder / "report.html"), "drive.bag"));
}

}  // namespace
}  // namespace lidar_mapping::tools
