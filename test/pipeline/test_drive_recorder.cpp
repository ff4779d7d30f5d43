// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/drive_recorder.hpp"
#include "lidar_mapping/session/session.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using localization::LocalizationResult;
using localization::LocalizationState;

constexpr auto kFollowing = LocalizationState::kFollowing;
constexpr auto kSearching = LocalizationState::kSearching;

LocalizationResult place_at(Stamp stamp, LocalizationState state = kFollowing) {
  LocalizationResult place;
  place.stamp = stamp;
  place.state = state;
  place.T_map_base.translation.x() = static_cast<double>(stamp);
  return place;
}

RunKeyFrame key_frame_at(Stamp stamp, KeyFrameIndex index, const std::string& run = "first") {
  RunKeyFrame result{run, {}};
  result.key_frame.index = index;
  result.key_frame.stamp = stamp;
  return result;
}

std::vector<Stamp> stamps_of(const std::vector<LocalizedKeyFrame>& pairs) {
  std::vector<Stamp> stamps;
  for (const LocalizedKeyFrame& pair : pairs) stamps.push_back(pair.key_frame.stamp);
  return stamps;
}

TEST(PlacePairing, PairsByEqualStampsWhicheverComesFirst) {
  PlacePairing pairing;
  pairing.add(key_frame_at(1, 0));
  EXPECT_TRUE(pairing.take_ready().empty()) << "its scan may still come";
  pairing.add(place_at(1));
  pairing.add(place_at(2));
  pairing.add(place_at(3));
  pairing.add(key_frame_at(3, 1));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(stamps_of(pairs), (std::vector<Stamp>{1, 3}));
  EXPECT_EQ(pairs[0].place.T_map_base.translation.x(), 1.0);
  EXPECT_EQ(pairs[1].place.T_map_base.translation.x(), 3.0);
  EXPECT_EQ(pairs[1].place.state, kFollowing);
  EXPECT_TRUE(pairing.take_ready().empty());
}

// Where a drive begins at speed, key frames come seconds after their scans.
TEST(PlacePairing, KeepsThePlacesOfKeyFramesThatComeLate) {
  PlacePairing pairing;
  for (Stamp stamp = 1; stamp <= 70; ++stamp) {
    pairing.add(place_at(stamp));
    EXPECT_TRUE(pairing.take_ready().empty());
  }
  for (const KeyFrameIndex i : {0U, 1U, 2U}) pairing.add(key_frame_at(1 + 20 * i, i));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(stamps_of(pairs), (std::vector<Stamp>{1, 21, 41}));
  for (const LocalizedKeyFrame& pair : pairs) EXPECT_EQ(pair.place.stamp, pair.key_frame.stamp);
}

// The front end sends its newest key frames again to a node that comes later.
TEST(PlacePairing, BeginsWithTheFirstScanThatWasLocalised) {
  PlacePairing pairing;
  for (const KeyFrameIndex i : {0U, 1U, 2U}) pairing.add(key_frame_at(10 * (1 + i), i));
  pairing.add(place_at(25));
  pairing.add(place_at(30));
  EXPECT_EQ(stamps_of(pairing.take_ready()), (std::vector<Stamp>{30}));
}

TEST(PlacePairing, TakesAKeyFrameAsSearchedForWhoseScanWasLost) {
  PlacePairing pairing;
  pairing.add(place_at(1));
  pairing.add(key_frame_at(2, 0));
  EXPECT_TRUE(pairing.take_ready().empty());
  pairing.add(place_at(3));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(stamps_of(pairs), (std::vector<Stamp>{2}));
  EXPECT_EQ(pairs[0].place.state, kSearching);
}

TEST(PlacePairing, NumbersTheRunOfARestartedFrontEndBehindTheOneBefore) {
  PlacePairing pairing;
  for (Stamp stamp = 1; stamp <= 5; ++stamp) pairing.add(place_at(stamp));
  pairing.add(key_frame_at(1, 0));
  RunKeyFrame second_segment = key_frame_at(2, 1);
  second_segment.key_frame.segment = 1;
  pairing.add(second_segment);
  pairing.add(key_frame_at(3, 0, "second"));
  pairing.add(key_frame_at(4, 1, "second"));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(pairs[i].key_frame.index, i);
  EXPECT_EQ(pairs[1].key_frame.segment, 1U);
  EXPECT_EQ(pairs[2].key_frame.segment, 2U) << "no odometry leads from one run to the next";
  EXPECT_EQ(pairs[3].key_frame.segment, 2U);
}

TEST(PlacePairing, LeavesOutKeyFramesWhoseTimeWentBack) {
  PlacePairing pairing;
  for (Stamp stamp = 1; stamp <= 9; ++stamp) pairing.add(place_at(stamp));
  pairing.add(key_frame_at(5, 0));
  pairing.add(key_frame_at(5, 0, "again"));
  pairing.add(key_frame_at(2, 1, "again"));
  pairing.add(key_frame_at(8, 2, "again"));
  EXPECT_EQ(stamps_of(pairing.take_ready()), (std::vector<Stamp>{5, 8}));
}

TEST(PlacePairing, KeepsTwentyKeyFramesWhileNoScanIsLocalised) {
  PlacePairing pairing;
  for (KeyFrameIndex i = 1; i <= 25; ++i) pairing.add(key_frame_at(i, i));
  EXPECT_TRUE(pairing.take_ready().empty());
  for (Stamp stamp = 1; stamp <= 25; ++stamp) pairing.add(place_at(stamp));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 20U);
  EXPECT_EQ(pairs.front().key_frame.stamp, 6);
}

TEST(PlacePairing, WithdrawsThePlaceBackToWhereItWasFound) {
  PlacePairing pairing;
  pairing.add(place_at(1));
  pairing.add(place_at(2, kSearching));
  for (const Stamp stamp : {3, 4}) pairing.add(place_at(stamp));
  EXPECT_EQ(pairing.withdraw_place(), 3) << "the place before was another one";
  EXPECT_EQ(pairing.withdraw_place(), std::nullopt) << "nothing is claimed any more";
  pairing.add(place_at(5));
  for (const Stamp stamp : {1, 3, 4, 5}) {
    pairing.add(key_frame_at(stamp, static_cast<KeyFrameIndex>(stamp)));
  }
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 4U);
  EXPECT_EQ(pairs[0].place.state, kFollowing);
  EXPECT_EQ(pairs[1].place.state, kSearching);
  EXPECT_EQ(pairs[2].place.state, kSearching);
  EXPECT_EQ(pairs[3].place.state, kFollowing);
  EXPECT_EQ(pairing.withdraw_place(), 5);
}

/// A recorder for a map that has no key frames.
class DriveRecorderTest : public testing::Test {
 protected:
  DriveRecorder make_recorder() const {
    const auto map = folder_.path() / "map";
    session::Session::create_in(map);
    return DriveRecorder(std::make_shared<MapExtender>(map, folder_.path() / "drive"));
  }
  std::vector<LocalizationState> states() const {
    std::vector<LocalizationState> states;
    for (const auto& [key_frame, place] : recorder_.drive().key_frames) {
      states.push_back(place.state);
    }
    return states;
  }
  void add(Stamp stamp, LocalizationState state) {
    recorder_.add_key_frame(key_frame_at(stamp, static_cast<KeyFrameIndex>(stamp)));
    recorder_.add_place(place_at(stamp, state));
  }

  const test::TemporaryFolder folder_;
  DriveRecorder recorder_ = make_recorder();
};

TEST_F(DriveRecorderTest, GivesAllThatWasAdded) {
  add(1, kSearching);
  add(2, kFollowing);
  recorder_.add_odometry(2, Pose::Identity());
  session::ScanRecord scan;
  scan.stamp = 2;
  recorder_.add_scan(scan);
  EXPECT_EQ(states(), (std::vector<LocalizationState>{kSearching, kFollowing}));
  ASSERT_EQ(recorder_.drive().odometry.size(), 1U);
  ASSERT_EQ(recorder_.drive().scans.size(), 1U);
  EXPECT_EQ(recorder_.drive().scans.front().stamp, 2);
}

TEST_F(DriveRecorderTest, WithdrawsThePlaceOfKeyFramesThatAreStored) {
  for (const Stamp stamp : {1, 2}) add(stamp, kFollowing);
  add(3, LocalizationState::kLost);
  for (const Stamp stamp : {4, 5}) add(stamp, kFollowing);
  recorder_.add_place(place_at(6));
  recorder_.withdraw_place();
  recorder_.add_key_frame(key_frame_at(6, 6));
  EXPECT_EQ(states(),
            (std::vector<LocalizationState>{kFollowing, kFollowing, LocalizationState::kLost,
                                            kSearching, kSearching, kSearching}));
}

/// A key frame whose scan was lost hid the wrong places before it.
TEST_F(DriveRecorderTest, WithdrawsThePlaceBeyondAKeyFrameWhoseScanWasLost) {
  add(1, kSearching);
  for (const Stamp stamp : {2, 3}) add(stamp, kFollowing);
  recorder_.add_key_frame(key_frame_at(4, 4));  // and no place for it
  for (const Stamp stamp : {5, 6}) add(stamp, kFollowing);
  recorder_.withdraw_place();
  EXPECT_EQ(states(), std::vector<LocalizationState>(6, kSearching));
}

}  // namespace
}  // namespace lidar_mapping::pipeline
