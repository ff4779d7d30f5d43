// SPDX-License-Identifier: BSD-3-Clause
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/key_frame_feed.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Indices = std::vector<KeyFrameIndex>;

ReceivedKeyFrame make(KeyFrameIndex index, const std::string& run = "run") {
  ReceivedKeyFrame result{{run, {}}, {}};
  result.key_frame.index = index;
  return result;
}

/// A back end that has some key frames, and a node that notes what it is given.
struct World {
  std::set<KeyFrameIndex> stored;
  std::string stored_run = "run";
  Indices delivered;
  Indices asked;
  std::size_t largest_request = 0;
  KeyFrameFeed feed{[this](const Indices& indices) {
                      asked.insert(asked.end(), indices.begin(), indices.end());
                      largest_request = std::max(largest_request, indices.size());
                      std::vector<ReceivedKeyFrame> found;
                      for (const KeyFrameIndex i : indices) {
                        if (stored.count(i) > 0) found.push_back(make(i, stored_run));
                      }
                      return found;
                    },
                    [this](const ReceivedKeyFrame& k) { delivered.push_back(k.key_frame.index); }};

  void store_until(KeyFrameIndex end) {
    for (KeyFrameIndex i = 0; i < end; ++i) stored.insert(i);
  }
  RunIndices known() const { return {stored_run, {stored.begin(), stored.end()}}; }
};

Indices counted(KeyFrameIndex end) {
  Indices result(end);
  std::iota(result.begin(), result.end(), 0U);
  return result;
}

TEST(KeyFrameFeed, HandsOnWhatArrivesInOrderWithoutAsking) {
  World world;
  for (KeyFrameIndex i = 0; i < 4; ++i) world.feed.push(make(i));
  EXPECT_EQ(world.delivered, counted(4));
  EXPECT_TRUE(world.asked.empty());
}

TEST(KeyFrameFeed, FetchesWhatTheTransportLost) {
  World world;
  world.store_until(10);
  world.feed.push(make(0));
  world.feed.push(make(3));
  EXPECT_EQ(world.delivered, counted(4));
  EXPECT_EQ(world.asked, (Indices{1, 2}));
  EXPECT_EQ(world.feed.missing(), 0U);
}

TEST(KeyFrameFeed, ANodeThatStartsInMidDriveGetsTheWholeRun) {
  World world;
  world.store_until(57);
  world.feed.push(make(57));
  EXPECT_EQ(world.delivered, counted(58));
  EXPECT_LE(world.largest_request, 10U) << "answers must stay small";
}

TEST(KeyFrameFeed, CatchesUpWithoutAnyMessage) {
  World world;
  world.store_until(25);
  world.feed.catch_up(world.known());
  EXPECT_EQ(world.delivered, counted(25));
  world.feed.push(make(25));
  EXPECT_EQ(world.delivered, counted(26));
}

TEST(KeyFrameFeed, CatchingUpAgainHandsNothingOnTwice) {
  World world;
  world.store_until(5);
  world.feed.catch_up(world.known());
  world.feed.catch_up(world.known());
  world.feed.push(make(4));
  EXPECT_EQ(world.delivered, counted(5));
}

TEST(KeyFrameFeed, WaitsForALateKeyFrameAndKeepsTheOrder) {
  World world;
  world.feed.push(make(0));
  world.feed.push(make(2));
  world.feed.push(make(3));
  EXPECT_EQ(world.delivered, counted(1));
  world.feed.push(make(1));
  EXPECT_EQ(world.delivered, counted(4));
}

TEST(KeyFrameFeed, AsksAgainForWhatTheBackEndDidNotHaveYet) {
  World world;
  world.feed.push(make(0));
  world.feed.push(make(2));
  world.stored.insert(1);
  world.feed.push(make(3));
  EXPECT_EQ(world.delivered, counted(4));
}

TEST(KeyFrameFeed, GivesUpAndCountsWhatNobodyHas) {
  World world;
  world.feed.push(make(0));
  for (KeyFrameIndex i = 3; i < 9; ++i) world.feed.push(make(i));
  EXPECT_EQ(world.delivered, (Indices{0, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(world.feed.missing(), 2U);
}

TEST(KeyFrameFeed, AGapInTheStoreDelaysNothing) {
  World world;
  world.stored = {0, 1, 5, 6};
  world.feed.catch_up(world.known());
  EXPECT_EQ(world.delivered, (Indices{0, 1, 5, 6}));
}

// The poses that moved are a list with gaps; catching up with it would skip key frames that exist.
TEST(KeyFrameFeed, SeesThatAPartLeavesOutKeyFramesThatAreMissing) {
  World world;
  world.store_until(10);
  world.feed.catch_up(world.known());
  const auto would_skip = [&](const Indices& indices, const std::string& run = "run") {
    return world.feed.would_skip({run, indices, false});
  };
  EXPECT_FALSE(would_skip({}));
  EXPECT_FALSE(would_skip({2, 5})) << "all have been delivered";
  EXPECT_FALSE(would_skip({2, 10, 11}));
  EXPECT_TRUE(would_skip({2, 11}));
  EXPECT_TRUE(would_skip({10, 12}));
  EXPECT_TRUE(would_skip({2, 5}, "next"));
  EXPECT_FALSE(would_skip({0, 1}, "next"));
  EXPECT_FALSE(world.feed.would_skip({"run", {2, 11}})) << "a whole list leaves out none";
}

TEST(KeyFrameFeed, AnotherRunBeginsAnew) {
  World world;
  world.feed.push(make(0));
  world.feed.push(make(1));
  world.feed.push(make(0, "next"));
  EXPECT_EQ(world.delivered, (Indices{0, 1, 0}));
  EXPECT_EQ(world.feed.run_id(), "next");
}

TEST(KeyFrameFeed, AnotherRunComesBehindWhatWaitsOfTheOneBefore) {
  World world;
  world.feed.push(make(0));
  world.feed.push(make(2));
  world.feed.push(make(0, "next"));
  world.feed.push(make(1, "next"));
  EXPECT_EQ(world.delivered, (Indices{0, 2, 0, 1}));
  EXPECT_EQ(world.feed.missing(), 1U);
}

TEST(KeyFrameFeed, NeverMixesRuns) {
  World world;
  world.store_until(5);
  world.stored_run = "old";
  world.feed.push(make(2, "new"));
  EXPECT_TRUE(world.delivered.empty());
}

TEST(KeyFrameFeed, GoesOnWhereTheRunStandsAndGivesUpWhenTold) {
  Indices delivered;
  KeyFrameFeed feed([](const Indices&) { return std::vector<ReceivedKeyFrame>(); },
                    [&](const ReceivedKeyFrame& k) { delivered.push_back(k.key_frame.index); },
                    [](const std::string&) { return KeyFrameIndex{25}; });
  for (const KeyFrameIndex i : {27U, 24U, 25U, 26U, 29U}) feed.push(make(i));
  EXPECT_EQ(delivered, (Indices{25, 26, 27}));
  EXPECT_EQ(feed.missing(), 0U);
  feed.flush();
  EXPECT_EQ(delivered, (Indices{25, 26, 27, 29}));
  EXPECT_EQ(feed.missing(), 1U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
