// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <fstream>
#include <random>

#include <sys/mount.h>

#include "mapped_drive.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::content_of;
using test::Program;
using test::TemporaryFolder;

/// Runs of map_bag that were broken off, and gone on with.
class Resume : public test::MappedDrive {
 protected:
  /// Begins a run and kills it. False if it was through before.
  static bool is_killed_after(double seconds, const fs::path& folder) {
    Program program("map_bag", with_bag({"-o", folder, "--formats", "pcd,ply,png"}),
                    root() / "log");
    program.ends_within(seconds);
    program.kill(SIGKILL);
    return program.wait() == 128 + SIGKILL;
  }
  /// Maps some seconds of the drive.
  void break_off() const {
    EXPECT_EQ(map({"-o", session_, "--duration", "6", "--formats", "pcd"}), 0);
    EXPECT_GT(key_frames_in(session_), 0U);
    EXPECT_LT(key_frames_in(session_), key_frames_in(whole()));
  }
  /// All that the undisturbed run left is in the folder then, byte for byte, and nothing half done.
  static void expect_same_bytes_after_resuming(const fs::path& folder) {
    EXPECT_EQ(map({"-o", folder, "--resume", "--formats", "pcd,ply,png"}), 0);
    for (const auto& entry : fs::recursive_directory_iterator(whole())) {
      const fs::path name = fs::relative(entry.path(), whole());
      // What readers share is no content.
      if (!entry.is_regular_file() || name == "run.json" || name == "lock" ||
          name == "session.db-shm") {
        continue;
      }
      EXPECT_TRUE(content_of(entry.path()) == content_of(folder / name)) << name;
    }
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
      EXPECT_NE(entry.path().filename(), ".resumed");
    }
    EXPECT_EQ(key_frames_in(folder), files_in(folder / "key_frames"));
  }
  /// The largest distance between key frames of two sessions with the same stamps.
  static double difference_to_whole(const fs::path& folder) {
    const auto poses_in = [](const fs::path& path) { return opened(path).poses().poses; };
    const auto expected = poses_in(whole());
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

  const fs::path session_ = folder_.path() / "session";
};

// The moments are spread over a whole run, the writing of the map included; the variable KILLS
// asks for more of them.
TEST_F(Resume, GivesTheBytesOfAnUndisturbedRunAfterAKillAtAnyMoment) {
  const char* asked = std::getenv("KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 4;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(0.0, 1.0);
  for (int i = 0; i < kills; ++i) {
    const TemporaryFolder parent;
    const fs::path folder = parent.path() / "session";
    const double moment = whole_seconds() * (i + within(random)) / kills;
    if (!is_killed_after(moment, folder)) continue;
    for (const char* file : {"map.pcd", "map.ply", "top_view.png"}) {
      if (!fs::exists(folder / "map" / file)) continue;
      EXPECT_EQ(content_of(folder / "map" / file), content_of(whole() / "map" / file)) << file;
    }
    expect_same_bytes_after_resuming(folder);
  }
}

TEST_F(Resume, GivesTheBytesOfAnUndisturbedRunAfterAStop) {
  Program program("map_bag", with_bag({"-o", session_, "--formats", "pcd"}), root() / "log");
  wait_for_key_frames(program, session_, 5);
  program.kill(SIGINT);
  EXPECT_EQ(program.wait(), 3) << said();
  EXPECT_TRUE(fs::exists(session_ / "map" / "map.pcd"));
  EXPECT_TRUE(fs::exists(session_ / "trajectory" / "optimized.tum"));
  expect_same_bytes_after_resuming(session_);
}

TEST_F(Resume, GivesTheBytesOfAnUndisturbedRunAfterAPart) {
  break_off();
  expect_same_bytes_after_resuming(session_);
  EXPECT_TRUE(has_said("key frames; they are mapped again"));
}

// The old session stays until the new one has come at least as far.
TEST_F(Resume, TakesNothingAwayIfItIsBrokenOffToo) {
  break_off();
  const std::string before = content_of(session_ / "trajectory" / "optimized.tum");
  Program program("map_bag", with_bag({"-o", session_, "--resume"}), root() / "log");
  wait_for_key_frames(program, session_ / ".resumed", 2);
  program.kill(SIGKILL);
  program.wait();
  EXPECT_EQ(content_of(session_ / "trajectory" / "optimized.tum"), before);
  ASSERT_EQ(map({"-o", session_, "--resume", "--duration", "2", "--no-map"}), 0);
  EXPECT_TRUE(has_said("is not changed"));
  EXPECT_EQ(content_of(session_ / "trajectory" / "optimized.tum"), before);
  expect_same_bytes_after_resuming(session_);
}

TEST_F(Resume, MakesTheMapAloneOfASessionThatIsComplete) {
  fs::copy(whole(), session_, fs::copy_options::recursive);
  fs::remove_all(session_ / "map");
  expect_same_bytes_after_resuming(session_);
  EXPECT_TRUE(has_said("all of the recording is mapped"));
  EXPECT_FALSE(has_said("times real time"));
}

TEST_F(Resume, QuicklyGoesOnNearTheEnd) {
  break_off();
  EXPECT_EQ(map({"-o", session_, "--quick-resume", "--no-map"}), 0);
  EXPECT_LT(difference_to_whole(session_), 0.02);
}

// A kill as run.json was written left a folder that was neither new nor a session.
TEST_F(Resume, BeginsWhereNothingButTheBeginningOfAFileIs) {
  fs::create_directories(session_);
  std::ofstream(session_ / ".run.json.part") << "{";
  expect_same_bytes_after_resuming(session_);
}

TEST_F(Resume, RefusesAnotherRecording) {
  break_off();
  const std::string before = content_of(session_ / "session.db");
  const std::string other = folder_.path() / "other.bag";
  ASSERT_EQ(run("simulate_drive", {other, "--lidar", "vlp16", "--duration", "3", "--seed", "2"}),
            0);
  for (const char* how : {"--resume", "--quick-resume"}) {
    EXPECT_EQ(run("map_bag", {other, "-o", session_, how}), 1);
    EXPECT_TRUE(has_said("is of another recording: it was made from drive.bag"));
  }
  EXPECT_EQ(map({"-o", session_, "--resume", "--parameter", "back_end/use_gnss: false"}), 1);
  EXPECT_TRUE(has_said("other parameters: back_end had 'use_gnss: true'"));
  EXPECT_EQ(map({"-o", session_, "--resume", "--start", "1"}), 1);
  EXPECT_TRUE(has_said("--start"));
  EXPECT_EQ(content_of(session_ / "session.db"), before);
}

TEST_F(Resume, FindsTheRecordingInAnotherFolder) {
  break_off();
  const std::string moved = folder_.path() / "renamed.bag";
  fs::create_hard_link(bag(), moved);
  EXPECT_EQ(run("map_bag", {moved, "-o", session_, "--resume", "--no-map"}), 0);
  EXPECT_EQ(key_frames_in(session_), key_frames_in(whole()));
}

TEST_F(Resume, RefusesASessionOfUnknownOrigin) {
  break_off();
  fs::remove(session_ / "run.json");
  EXPECT_EQ(map({"-o", session_, "--resume"}), 1);
  EXPECT_TRUE(has_said("which recording"));
}

TEST_F(Resume, KeepsWhatAPersonDecided) {
  break_off();
  {
    Session session = Session::open(session_, Session::Access::kWrite);
    Loop loop;
    loop.to = 2;
    session.add_loop(loop);
    session.set_loop_decision(0, 2, LoopDecision::kRefuse);
  }
  EXPECT_EQ(map({"-o", session_, "--resume"}), 1);
  EXPECT_TRUE(has_said("a user has decided about loops"));
}

TEST_F(Resume, KeepsTheSessionWholeOnAFullDisk) {
  const TemporaryFolder disk;
  if (mount("tmpfs", disk.path().c_str(), "tmpfs", 0, "size=3m") != 0) {
    GTEST_SKIP() << "may not mount a small disk";
  }
  const fs::path folder = disk.path() / "session";
  EXPECT_EQ(map({"-o", folder.string(), "--no-map"}), 1);
  EXPECT_TRUE(has_said((folder / "key_frames").string()));
  {
    const Session session = opened(folder);
    EXPECT_GT(session.key_frame_count(), 0U);
    for (const KeyFrame& key_frame : session.key_frames()) {
      EXPECT_NE(session.clouds().cloud(key_frame.index), nullptr) << key_frame.index;
    }
  }
  ASSERT_EQ(mount("tmpfs", disk.path().c_str(), "tmpfs", MS_REMOUNT, "size=100m"), 0);
  EXPECT_EQ(map({"-o", folder.string(), "--resume", "--no-map"}), 0);
  EXPECT_EQ(key_frames_in(folder), key_frames_in(whole()));
  EXPECT_LT(difference_to_whole(folder), 1e-9);
  umount(disk.path().c_str());
}

}  // namespace
}  // namespace lidar_mapping::tools
