// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/pose_feed.hpp"

namespace lidar_mapping::ros_border {
namespace {

KeyFramePose pose_of(KeyFrameIndex index, double x) {
  KeyFramePose pose;
  pose.index = index;
  pose.stamp = index;
  pose.T_map_base.translation.x() = x;
  return pose;
}

/// All `count` key frames at a revision; their x is the revision.
RunPoses all(KeyFrameIndex count, std::uint32_t revision, const std::string& run = "run") {
  RunPoses result{run, {}};
  result.poses.revision = revision;
  for (KeyFrameIndex i = 0; i < count; ++i) result.poses.poses.push_back(pose_of(i, revision));
  return result;
}

/// One key frame that moved between two revisions.
RunPoses part(KeyFrameIndex index, std::uint32_t since, std::uint32_t revision,
              const std::string& run = "run") {
  return {run, {revision, false, {pose_of(index, revision)}, since}};
}

/// A back end that answers with what is stored, and a node that listens to it.
struct BackEndWorld {
  std::optional<RunPoses> stored;
  int asked = 0;
  PoseFeed feed{[this] {
    ++asked;
    return stored;
  }};

  /// x of all known key frames of a run.
  std::vector<double> known(const std::string& run = "run") const {
    std::vector<double> result;
    for (const KeyFramePose& pose : feed.known(run).poses) {
      result.push_back(pose.T_map_base.translation.x());
    }
    return result;
  }
};

using Values = std::vector<double>;

TEST(PoseFeed, PutsTogetherAllPosesAndThoseThatMoved) {
  BackEndWorld world;
  EXPECT_TRUE(world.feed.push(all(3, 1)));
  const auto changed = world.feed.push(part(1, 1, 2));
  ASSERT_TRUE(changed);
  EXPECT_FALSE(changed->poses.whole);
  EXPECT_EQ(changed->poses.poses.size(), 1U) << "the node is spared the others";
  world.feed.push(part(3, 2, 3));
  EXPECT_EQ(world.known(), (Values{1, 2, 1, 3}));
  EXPECT_EQ(world.feed.known("run").revision, 3U);
  EXPECT_EQ(world.asked, 0);
}

TEST(PoseFeed, FetchesAllWhereAMessageIsMissing) {
  BackEndWorld world;
  world.feed.push(all(3, 1));
  world.stored = all(3, 3);
  const auto changed = world.feed.push(part(1, 2, 3));
  EXPECT_EQ(world.asked, 1);
  ASSERT_TRUE(changed);
  EXPECT_TRUE(changed->poses.whole);
  EXPECT_EQ(changed->poses.poses.size(), 3U);
  EXPECT_EQ(world.known(), (Values{3, 3, 3}));
  EXPECT_TRUE(world.feed.push(part(2, 3, 4))) << "the sequence goes on";
  EXPECT_EQ(world.asked, 1);
}

TEST(PoseFeed, FetchesAllIfAPartComesFirst) {
  BackEndWorld world;
  world.stored = all(3, 5);
  world.feed.push(part(1, 4, 5));
  EXPECT_EQ(world.known(), (Values{5, 5, 5}));
}

// What was fetched overtakes the messages that wait in the queue.
TEST(PoseFeed, LeavesOutPartsThatAreOlderThanWhatWasFetched) {
  BackEndWorld world;
  world.feed.push(all(3, 1));
  world.stored = all(3, 5);
  world.feed.push(part(1, 2, 3));
  EXPECT_FALSE(world.feed.push(part(1, 3, 4)));
  EXPECT_FALSE(world.feed.push(part(2, 4, 5)));
  EXPECT_EQ(world.known(), (Values{5, 5, 5}));
  EXPECT_TRUE(world.feed.push(part(0, 5, 6)));
  EXPECT_EQ(world.known(), (Values{6, 5, 5}));
  EXPECT_EQ(world.asked, 1);
}

// A solution that hardly moves anything is no message, but a revision that can be fetched.
TEST(PoseFeed, TakesAPartThatContinuesAnOlderRevisionThanTheFetchedOne) {
  BackEndWorld world;
  world.feed.push(all(3, 5));
  EXPECT_TRUE(world.feed.push(part(1, 3, 6)));
  EXPECT_EQ(world.asked, 0);
  EXPECT_EQ(world.known(), (Values{5, 6, 5}));
}

TEST(PoseFeed, TakesThePartAndAsksAgainWhereNobodyAnswers) {
  BackEndWorld world;
  EXPECT_TRUE(world.feed.push(part(1, 1, 2)));
  EXPECT_EQ(world.known(), (Values{2}));
  EXPECT_TRUE(world.feed.push(part(2, 2, 3)));
  EXPECT_EQ(world.asked, 2) << "the poses of before are still missing";
  world.stored = all(4, 4);
  world.feed.push(part(2, 3, 4));
  EXPECT_EQ(world.known(), (Values{4, 4, 4, 4}));
  world.feed.push(part(2, 4, 5));
  EXPECT_EQ(world.asked, 3);
}

TEST(PoseFeed, TakesThePartWhereTheAnswerIsOlderOrNotWhole) {
  BackEndWorld world;
  world.feed.push(all(3, 1));
  world.stored = all(3, 2);
  EXPECT_FALSE(world.feed.push(part(1, 3, 4))->poses.whole);
  world.stored = part(2, 4, 6);
  world.feed.push(part(0, 5, 6));
  EXPECT_EQ(world.known(), (Values{6, 4, 1}));
}

// A back end that was killed counts on from its session, and begins with all poses.
TEST(PoseFeed, TakesAllPosesWhateverTheirRevision) {
  BackEndWorld world;
  world.feed.push(all(3, 9));
  EXPECT_TRUE(world.feed.push(all(2, 4)));
  EXPECT_EQ(world.known(), (Values{4, 4}));
  EXPECT_TRUE(world.feed.push(part(1, 4, 5)));
  EXPECT_EQ(world.asked, 0);
}

TEST(PoseFeed, AnotherRunBeginsAnew) {
  BackEndWorld world;
  world.feed.push(all(3, 7));
  world.feed.push(all(2, 1, "next"));
  EXPECT_TRUE(world.known().empty());
  EXPECT_EQ(world.known("next"), (Values{1, 1}));
  world.stored = all(1, 2, "last");
  const auto changed = world.feed.push(part(0, 1, 2, "last"));
  EXPECT_EQ(world.asked, 1);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->run_id, "last");
  EXPECT_EQ(world.known("last"), (Values{2}));
}

TEST(PoseFeed, NamesTheKeyFramesOfAPart) {
  const RunIndices some = part(4, 1, 2).indices();
  EXPECT_EQ(some.run_id, "run");
  EXPECT_EQ(some.indices, (std::vector<KeyFrameIndex>{4}));
  EXPECT_FALSE(some.whole);
  EXPECT_TRUE(all(2, 1).indices().whole);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
