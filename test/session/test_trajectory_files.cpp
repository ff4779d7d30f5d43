// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>

#include <gtest/gtest.h>

#include "lidar_mapping/session/trajectory_files.hpp"

#include "example_values.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::session {
namespace {

using test::TemporaryFolder;

constexpr KeyFrameIndex kKeyFrames = 8;

KeyFramePoses example_poses() {
  KeyFramePoses poses;
  poses.revision = 1;
  for (KeyFrameIndex index = 0; index < kKeyFrames; ++index) {
    std::mt19937 random(index + 100);
    poses.poses.push_back({index, example_key_frame(index).stamp, random_pose(random)});
  }
  return poses;
}

GnssPosition example_gnss(KeyFrameIndex index) {
  GnssPosition position;
  position.stamp = example_key_frame(index).stamp;
  position.p_enu_antenna = {1.0 * index, 2.0, 3.0};
  position.p_base_antenna = {0.0, 0.0, 1.5};
  return position;
}

Session example_session(const std::filesystem::path& folder) {
  Session session = Session::create_in(folder);
  for (KeyFrameIndex index = 0; index < kKeyFrames; ++index) {
    session.add_key_frame(example_key_frame(index));
  }
  return session;
}

// All files contain the same key frames with stamps and lose no digits.
TEST(TrajectoryFiles, ContainTheSameKeyFramesToAMicrometre) {
  const TemporaryFolder folder;
  const Session session = example_session(folder.path());
  const KeyFramePoses poses = example_poses();
  write_trajectories(session, poses, session.gnss(), folder.path() / "trajectory");

  const auto read = [&](const std::string& name) {
    return read_trajectory((folder.path() / "trajectory" / name).string());
  };
  for (const std::string name : {"laser_odom.tum", "laser_odom.txt", "optimized.txt"}) {
    EXPECT_EQ(read(name).poses.size(), kKeyFrames) << name;
  }
  const Trajectory tum = read("optimized.tum");
  const Trajectory kitti = read("optimized.txt");
  ASSERT_EQ(tum.poses.size(), kKeyFrames);
  for (std::size_t i = 0; i < kKeyFrames; ++i) {
    const Pose& expected = poses.poses[i].T_map_base;
    EXPECT_EQ(tum.poses[i].stamp, poses.poses[i].stamp);
    EXPECT_TRUE(test::near(tum.poses[i].pose.translation, expected.translation, 1e-6));
    EXPECT_TRUE(test::near(kitti.poses[i].pose.translation, expected.translation, 1e-6));
    EXPECT_TRUE(test::near(kitti.poses[i].pose, expected, 1e-5));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "trajectory" / "ground_truth.txt"));
}

TEST(TrajectoryFiles, AreReadByAnIndependentReader) {
  const TemporaryFolder folder;
  Session session = example_session(folder.path() / "session");
  session.add_gnss(example_gnss(2));
  session.add_odometry(example_key_frame(2).stamp, Pose::Identity());
  write_trajectories(session, example_poses(), session.gnss(), folder.path() / "trajectory");
  const std::string files = (folder.path() / "trajectory").string();
  EXPECT_EQ(std::system(("python3 session/read_trajectory_files.py " + files).c_str()), 0);
}

TEST(TrajectoryFiles, AreReadByEvo) {
  if (std::system("command -v evo_ape >/dev/null 2>&1") != 0) GTEST_SKIP() << "evo is not here";
  const TemporaryFolder folder;
  Session session = example_session(folder.path() / "session");
  write_trajectories(session, example_poses(), session.gnss(), folder.path() / "trajectory");
  const std::string files = (folder.path() / "trajectory").string();
  for (const std::string& command :
       {"evo_ape tum " + files + "/optimized.tum " + files + "/laser_odom.tum",
        "evo_ape kitti " + files + "/optimized.txt " + files + "/laser_odom.txt"}) {
    EXPECT_EQ(std::system((command + " >/dev/null").c_str()), 0) << command;
  }
}

// The GNSS track is also written with the name gnss, and its lines correspond to those of the
// others.
TEST(TrajectoryFiles, KittiFilesContainTheKeyFramesWithAGnssPosition) {
  const TemporaryFolder folder;
  Session session = example_session(folder.path());
  for (const KeyFrameIndex index : {1U, 2U, 5U}) session.add_gnss(example_gnss(index));
  const KeyFramePoses poses = example_poses();
  write_trajectories(session, poses, session.gnss(), folder.path());

  const auto read = [&](const std::string& name) {
    return read_trajectory((folder.path() / name).string());
  };
  for (const std::string name : {"ground_truth", "gnss", "laser_odom", "optimized"}) {
    EXPECT_EQ(read(name + ".txt").poses.size(), 3U) << name;
  }
  EXPECT_EQ(read("optimized.tum").poses.size(), kKeyFrames);
  const Trajectory gnss = read("gnss.tum");
  ASSERT_EQ(gnss.poses.size(), 3U);
  EXPECT_EQ(gnss.poses[2].stamp, example_key_frame(5).stamp);
  const Eigen::Quaterniond& rotation = poses.poses[5].T_map_base.rotation;
  const Eigen::Vector3d expected =
      Eigen::Vector3d(5.0, 2.0, 3.0) - rotation * Eigen::Vector3d(0.0, 0.0, 1.5);
  EXPECT_TRUE(test::near(gnss.poses[2].pose.translation, expected, 1e-6));
}

}  // namespace
}  // namespace lidar_mapping::session
