#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <sys/mount.h>

#include "lidar_mapping/session/session.hpp"

#include "program.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::Program;
using test::TemporaryFolder;
using test::Words;
using Clock = std::chrono::steady_clock;

/// Short drives through the command itself.
class MapBag : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    static const TemporaryFolder folder;
    root() = folder.path();
    Program simulation("simulate_drive", {bag(), "--lidar", "vlp16", "--duration", "14"},
                       root() / "log");
    ASSERT_EQ(simulation.wait(), 0) << simulation.output();
    const auto begin = Clock::now();
    ASSERT_EQ(
        map({"-o", (root() / "whole").string(), "--threads", "2", "--formats", "pcd,ply,png"}), 0)
        << said();
    whole_seconds() = std::chrono::duration<double>(Clock::now() - begin).count();
  }
  /// That an undisturbed run takes.
  static double& whole_seconds() {
    static double seconds = 0.0;
    return seconds;
  }
  static fs::path& root() {
    static fs::path path;
    return path;
  }
  static std::string bag() { return (root() / "drive.bag").string(); }

  static Words with_bag(Words words) {
    words.insert(words.begin(), bag());
    return words;
  }
  static int map(const Words& words) {
    return Program("map_bag", with_bag(words), root() / "log").wait();
  }
  static std::string said() {
    std::ifstream file(root() / "log");
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static std::size_t files_in(const fs::path& folder) {
    if (!fs::exists(folder)) return 0;
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  /// Waits until so many key frames have been written, or the program has ended.
  static void wait_for_key_frames(const Program& program, const fs::path& folder,
                                  std::size_t count) {
    while (program.is_running() && files_in(folder / "key_frames") < count) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  /// The largest distance between key frames of two sessions with the same stamps.
  static double difference_to_whole(const fs::path& folder) {
    const auto poses_in = [](const fs::path& path) {
      return Session::open(path, Session::Access::kRead).poses().poses;
    };
    const auto expected = poses_in(root() / "whole");
    const auto poses = poses_in(folder);
    if (poses.size() != expected.size() || poses.empty()) return 1e9;
    double largest = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (poses[i].stamp != expected[i].stamp) return 1e9;
      const Eigen::Vector3d difference =
          poses[i].T_map_base.translation - expected[i].T_map_base.translation;
      largest = std::max(largest, difference.norm());
    }
    return largest;
  }
  /// Begins a run and kills it. False if it was through before.
  static bool is_killed_after(double seconds, const fs::path& folder) {
    Program program("map_bag", with_bag({"-o", folder.string(), "--formats", "pcd,ply,png"}),
                    root() / "log");
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    while (program.is_running() && Clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    program.kill(SIGKILL);
    return program.wait() == 128 + SIGKILL;
  }
  static std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  static std::size_t unfinished_files(const fs::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() == ".part") ++count;
    }
    return count;
  }
};

TEST_F(MapBag, MakesASessionAndItsMap) {
  for (const char* name : {"session.db", "config.yaml", "trajectory/optimized.tum", "map/map.pcd",
                           "map/map.yaml", "graph.g2o", "key_frames/000000.pcd"}) {
    EXPECT_TRUE(fs::exists(root() / "whole" / name)) << name;
  }
  EXPECT_GT(Session::open(root() / "whole", Session::Access::kRead).key_frame_count(), 10U);
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
  EXPECT_NE(said().find("nothing in the recording leads from 'velo_link' to 'base_link'"),
            std::string::npos)
      << said();
  EXPECT_NE(said().find("map_bag takes the times of their recording"), std::string::npos);
  EXPECT_GT(Session::open(session, Session::Access::kRead).key_frame_count(), 2U);
}

TEST_F(MapBag, LeavesAFolderAloneThatIsNotEmpty) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "diary.txt") << "mine";
  EXPECT_EQ(map({"-o", folder.path().string()}), 1);
  EXPECT_NE(said().find("is not empty"), std::string::npos) << said();
  EXPECT_NE(said().find("--resume"), std::string::npos);
  EXPECT_EQ(files_in(folder.path()), 1U);
}

// The moments are spread over a whole run, the writing of the map included; the variable KILLS
// asks for more of them.
TEST_F(MapBag, GoesOnAfterAKillAtAnyMoment) {
  const char* asked = std::getenv("KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 6;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(0.0, 1.0);
  for (int i = 0; i < kills; ++i) {
    const TemporaryFolder parent;
    const fs::path folder = parent.path() / "session";
    const double moment = whole_seconds() * (i + within(random)) / kills;
    if (!is_killed_after(moment, folder)) continue;
    for (const char* file : {"map.pcd", "map.ply", "top_view.png"}) {
      if (!fs::exists(folder / "map" / file)) continue;
      EXPECT_EQ(content(folder / "map" / file), content(root() / "whole/map" / file)) << file;
    }
    EXPECT_EQ(map({"-o", folder.string(), "--resume", "--formats", "pcd,ply,png"}), 0) << said();
    EXPECT_LT(difference_to_whole(folder), 0.02) << "killed after " << moment << " s";
    EXPECT_TRUE(fs::exists(folder / "map/top_view.png"));
    EXPECT_EQ(unfinished_files(folder), 0U);
  }
}

TEST_F(MapBag, SavesWhatThereIsWhenItIsStopped) {
  const TemporaryFolder parent;
  const fs::path folder = parent.path() / "session";
  Program program("map_bag", with_bag({"-o", folder.string(), "--formats", "pcd"}), root() / "log");
  wait_for_key_frames(program, folder, 5);
  program.kill(SIGINT);
  EXPECT_EQ(program.wait(), 3) << said();
  EXPECT_TRUE(fs::exists(folder / "map" / "map.pcd"));
  EXPECT_TRUE(fs::exists(folder / "trajectory" / "optimized.tum"));
  EXPECT_EQ(map({"-o", folder.string(), "--resume", "--no-map"}), 0) << said();
  EXPECT_LT(difference_to_whole(folder), 0.02);
}

TEST_F(MapBag, ReadsFoldersOfKittiAndKittiToBagWritesThem) {
  const TemporaryFolder parent;
  const fs::path odometry = parent.path() / "odometry";
  const fs::path raw = parent.path() / "raw";
  const auto run = [&](const std::string& program, const Words& words) {
    return Program(program, words, root() / "log").wait();
  };
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

// Without what was in them the drive is as whole as with scans that never came.
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
  EXPECT_NE(said().find("is left out"), std::string::npos) << said();
  const auto key_frames = [](const fs::path& folder) {
    return Session::open(folder, Session::Access::kRead).key_frame_count();
  };
  EXPECT_GE(key_frames(root() / "rest") + 4, key_frames(root() / "whole"));
}

TEST_F(MapBag, SaysWhichTopicIsMissing) {
  const TemporaryFolder parent;
  EXPECT_EQ(map({"-o", (parent.path() / "s").string(), "--points", "/no/such"}), 1);
  EXPECT_NE(said().find("/no/such"), std::string::npos) << said();
  EXPECT_FALSE(fs::exists(parent.path() / "s"));
}

TEST_F(MapBag, TakesTheNameOfASensorAndListsThemWhereItIsUnknown) {
  const TemporaryFolder parent;
  EXPECT_EQ(map({"-o", (parent.path() / "s").string(), "--sensor", "vlp61"}), 1);
  EXPECT_NE(said().find("vlp61"), std::string::npos) << said();
  EXPECT_NE(said().find("kitti, livox, os1, robosense, vlp16"), std::string::npos) << said();
  EXPECT_EQ(map({"-o", (parent.path() / "s").string(), "--sensor", "vlp16", "--no-map"}), 0)
      << said();
}

TEST_F(MapBag, KeepsTheSessionWholeOnAFullDisk) {
  const TemporaryFolder disk;
  if (mount("tmpfs", disk.path().c_str(), "tmpfs", 0, "size=3m") != 0) {
    GTEST_SKIP() << "may not mount a small disk";
  }
  const fs::path folder = disk.path() / "session";
  EXPECT_EQ(map({"-o", folder.string(), "--no-map"}), 1);
  EXPECT_NE(said().find((folder / "key_frames").string()), std::string::npos) << said();
  {
    const Session session = Session::open(folder, Session::Access::kRead);
    EXPECT_GT(session.key_frame_count(), 0U);
    for (const KeyFrame& key_frame : session.key_frames()) {
      EXPECT_NE(session.clouds().cloud(key_frame.index), nullptr) << key_frame.index;
    }
  }
  EXPECT_EQ(unfinished_files(folder), 0U);
  ASSERT_EQ(mount("tmpfs", disk.path().c_str(), "tmpfs", MS_REMOUNT, "size=100m"), 0);
  EXPECT_EQ(map({"-o", folder.string(), "--resume", "--no-map"}), 0) << said();
  EXPECT_LT(difference_to_whole(folder), 0.02);
  umount(disk.path().c_str());
}

}  // namespace
}  // namespace lidar_mapping::tools
