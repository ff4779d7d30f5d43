// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/session/session.hpp"

#include "back_end_fixture.hpp"
#include "near.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;

// Killed in mid-drive and started again, it goes on with the session.
TEST_F(BackEndNode, GoesOnWithItsSessionAfterItWasKilled) {
  auto node = start();
  publish(0, 25);
  ASSERT_TRUE(wait_for_key_frames(25));
  node->kill();
  node = start();
  publish(25, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  loops_.publish(round_loop());
  EXPECT_TRUE(wait_until([&] { return optimize().loops_used == 1; }));
  EXPECT_LT(ros_border::from_message(known().poses).poses.back().T_map_base.translation.norm(),
            0.1);
  EXPECT_EQ(sessions().size(), 1U);
}

TEST_F(BackEndNode, ResumesASessionOnRequest) {
  auto node = start();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10));
  node->stop();
  poses_.messages.clear();
  node = start({"_resume:=latest"});
  ASSERT_TRUE(poses_.wait_for(1)) << "latched: " << node->output();
  EXPECT_EQ(poses_.messages[0].indices.size(), 10U);
  EXPECT_EQ(poses_.messages[0].run_id, "run");
}

/// A drive without loops and GNSS is solved for the first time when it is resumed.
TEST_F(BackEndNode, LeavesWhatItHasSolvedOfAResumedSession) {
  auto node = start();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10));
  node->stop();
  const fs::path folder = sessions().front();
  const auto stored_poses = [&] {
    return session::Session::open(folder, session::Session::Access::kRead).poses().poses.size();
  };
  EXPECT_EQ(stored_poses(), 0U);
  fs::remove(folder / "graph.g2o");
  node = start({"_resume:=latest"});
  ASSERT_TRUE(wait_for_key_frames(10)) << node->output();
  node->stop();
  EXPECT_EQ(stored_poses(), 10U);
  EXPECT_TRUE(fs::exists(folder / "graph.g2o"));
}

TEST_F(BackEndNode, SaysThatAnotherRunEndsTheSessionThatItResumed) {
  auto node = start();
  publish(0, 5, "first");
  ASSERT_TRUE(wait_for_key_frames(5));
  node->stop();
  node = start({"_resume:=latest"});
  publish(5, 6, "first");
  ASSERT_TRUE(wait_for_key_frames(6)) << node->output();
  EXPECT_FALSE(node->says("does not go on with")) << node->output();
  publish(0, 3, "second");
  EXPECT_TRUE(wait_until([&] {
    return node->says("run 'second' arrive, which does not go on with the resumed session 'first'");
  })) << node->output();
}

/// front_end_node waits for it before the first scan.
TEST_F(BackEndNode, IsNotWaitedForIfItCannotReadTheSession) {
  for (const char* mistake : {"_resume:=/no/such/session", "_queue_size:=0"}) {
    ros::param::set("/run_state/resuming", "back_end_node");
    NodeProcess node("back_end_node", {"--stay-on-error", mistake});
    EXPECT_TRUE(wait_until([] { return !ros::param::has("/run_state/resuming"); }))
        << node.output();
    EXPECT_TRUE(node.is_running()) << node.output();
  }
}

TEST_F(BackEndNode, ResumesASessionOfMapBagWhichBelongsToNoRun) {
  auto node = start();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10));
  node->stop();
  const fs::path folder = sessions().front();
  session::Session::open(folder, session::Session::Access::kWrite).set_run_id("");
  node = start({"_resume:=" + folder.string()});
  ASSERT_TRUE(wait_for_key_frames(10)) << node->output();
  EXPECT_EQ(known().poses.run_id, folder.filename().string());
  publish(10, 12, known().poses.run_id);
  EXPECT_TRUE(wait_for_key_frames(12)) << node->output();
  EXPECT_EQ(sessions().size(), 1U);
}

// Another run gets a session of its own.
TEST_F(BackEndNode, AnotherRunBeginsAnotherSession) {
  const auto node = start();
  publish(0, 5, "first");
  ASSERT_TRUE(wait_for_key_frames(5));
  publish(0, 3, "second");
  ASSERT_TRUE(wait_for_key_frames(3));
  EXPECT_EQ(known().poses.run_id, "second");
  EXPECT_EQ(sessions().size(), 2U);
}

/// As the services of hdl_graph_slam: what was dumped is loaded by a node that knows nothing.
TEST_F(BackEndNode, DumpsItsGraphAndLoadsItBeforeADrive) {
  auto node = start();
  const fs::path place = folder_.path() / "dump";
  EXPECT_NE(dump(place).message.find("no key frames"), std::string::npos);
  publish(0, kRound);
  ASSERT_TRUE(wait_for_key_frames(kRound)) << node->output();
  loops_.publish(round_loop());
  ASSERT_TRUE(wait_until([&] { return optimize().loops_used == 1; }));
  const DumpGraph::Response dumped = dump(place);
  EXPECT_TRUE(dumped.success) << dumped.message;
  EXPECT_EQ(dumped.key_frames, static_cast<std::uint32_t>(kRound));
  EXPECT_EQ(dumped.directory, place.string());
  EXPECT_TRUE(fs::exists(place / "000000" / "cloud.pcd"));
  const DumpGraph::Response again = dump(place);
  EXPECT_FALSE(again.success);
  EXPECT_NE(again.message.find("is there already"), std::string::npos) << again.message;
  const LoadGraph::Response late = load(place);
  EXPECT_FALSE(late.success);
  EXPECT_NE(late.message.find("a drive is under way"), std::string::npos) << late.message;
  EXPECT_EQ(sessions().size(), 1U);
  node->stop();

  const fs::path before = sessions().front();
  node = start();
  EXPECT_FALSE(load(folder_.path() / "nothing").success);
  const LoadGraph::Response loaded = load(place);
  ASSERT_TRUE(loaded.success) << loaded.message;
  EXPECT_EQ(loaded.key_frames, static_cast<std::uint32_t>(kRound));
  EXPECT_EQ(loaded.loops, 1U);
  EXPECT_NE(loaded.session, before.string()) << "the old session stays as it was";
  EXPECT_EQ(sessions().size(), 2U);
  const KeyFramePoses poses = ros_border::from_message(known().poses);
  ASSERT_EQ(poses.poses.size(), static_cast<std::size_t>(kRound));
  EXPECT_TRUE(test::near(poses.poses.back().T_map_base.translation, Eigen::Vector3d::Zero(), 0.1))
      << "the loop is closed";
  EXPECT_EQ(known(true, {3}).key_frames.at(0).cloud.width, round_message(3).cloud.width);
  EXPECT_FALSE(load(place).success) << "what was loaded is a drive that goes on";
  publish(kRound, kRound + 1, known().poses.run_id);
  EXPECT_TRUE(wait_for_key_frames(kRound + 1)) << node->output();
}

TEST_F(BackEndNode, LoadsASessionAndGoesOnInIt) {
  auto node = start();
  publish(0, 10);
  ASSERT_TRUE(wait_for_key_frames(10));
  EXPECT_EQ(dump("").directory, (sessions().front() / "hdl_dump").string());
  node->stop();
  node = start();
  const LoadGraph::Response loaded = load(folder_.path() / "sessions");
  ASSERT_TRUE(loaded.success) << loaded.message;
  EXPECT_EQ(loaded.session, sessions().front().string());
  EXPECT_EQ(known().poses.run_id, "run");
  publish(10, 12);
  EXPECT_TRUE(wait_for_key_frames(12)) << node->output();
  EXPECT_EQ(sessions().size(), 1U);
}

// A session without key frames gives way to one that is loaded, and stays if that cannot be read.
TEST_F(BackEndNode, KeepsAnEmptySessionUntilAnotherOneIsOpen) {
  const fs::path empty = folder_.path() / "empty";
  fs::create_directories(empty);
  std::ofstream(empty / "session.db").close();  // as of a node that was killed at once
  const auto node = start({"_resume:=" + empty.string()});
  ASSERT_EQ(known().poses.header.frame_id, "map") << node->output();
  const std::string missing = load(folder_.path() / "nothing").message;
  EXPECT_NE(missing.find("there is no session in"), std::string::npos) << missing;
  EXPECT_EQ(known().poses.header.frame_id, "map") << "its session is still open";
  const std::string itself = load(empty).message;
  EXPECT_NE(itself.find("has no key frames"), std::string::npos) << itself;
  EXPECT_EQ(known().poses.header.frame_id, "map") << "its session is still open";
}

TEST_F(BackEndNode, EndsWithAMessageWhereNoSessionCanBeStored) {
  std::ofstream(folder_.path() / "file").close();
  NodeProcess node("back_end_node",
                   {"_session_directory:=" + (folder_.path() / "file" / "sessions").string()});
  EXPECT_EQ(node.wait(), 1);
  EXPECT_TRUE(node.says("session_directory: cannot put data aside in")) << node.output();
}

/// A whole drive was lost, and the answer was that there was nothing to optimise.
TEST_F(BackEndNode, SaysWhyKeyFramesCouldNotBeStored) {
  const auto node = start();
  fs::remove_all(folder_.path() / "sessions");
  std::ofstream(folder_.path() / "sessions").close();
  publish(0, 3);
  EXPECT_TRUE(wait_until([&] {
    return optimize().message.find("3 key frames could not be stored (") == 0;
  })) << node->output();
  fs::remove(folder_.path() / "sessions");
  publish(0, 2);
  ASSERT_TRUE(wait_for_key_frames(2)) << node->output();
  EXPECT_NE(optimize().message.find(" 1 key frames could not be stored ("), std::string::npos);
  publish(2, 3);
  ASSERT_TRUE(wait_for_key_frames(3)) << node->output();
  const OptimizeMap::Response answer = optimize();
  EXPECT_TRUE(answer.success);
  EXPECT_EQ(answer.message.find("could not be stored"), std::string::npos) << answer.message;
}

TEST_F(BackEndNode, EndsWithAMessageWhereThereIsNoSessionToResume) {
  NodeProcess node("back_end_node", {"_resume:=" + (folder_.path() / "nothing").string()});
  EXPECT_EQ(node.wait(), 1);
  EXPECT_TRUE(node.says("there is no session in")) << node.output();
}

}  // namespace
}  // namespace lidar_mapping::test
