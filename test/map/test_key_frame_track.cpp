// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/map/key_frame_track.hpp"

namespace lidar_mapping::map {
namespace {

KeyFrame key_frame_at(KeyFrameIndex index, double x) {
  KeyFrame key_frame;
  key_frame.index = index;
  key_frame.stamp = 100 * Stamp{index};
  key_frame.T_odom_base.translation.x() = x;
  return key_frame;
}

/// All key frames up to `last` moved along y by `shift`.
KeyFramePoses shifted(KeyFrameIndex last, double shift) {
  KeyFramePoses poses;
  for (KeyFrameIndex index = 0; index <= last; ++index) {
    Pose pose;
    pose.translation = {1.0 * index, shift, 0.0};
    poses.poses.push_back({index, 100 * Stamp{index}, pose});
  }
  return poses;
}

// Three optimisations in a row: newer key frames follow the newest correction.
TEST(KeyFrameTrack, NewCorrectionsReplaceOlderOnes) {
  KeyFrameTrack track;
  for (KeyFrameIndex index = 0; index < 10; ++index) track.add(key_frame_at(index, 1.0 * index));
  for (const double shift : {1.0, 3.0, -2.0}) {
    track.update(shifted(7, shift));
    const KeyFramePoses poses = track.poses();
    ASSERT_EQ(poses.poses.size(), 10U);
    for (const KeyFramePose& pose : poses.poses) {
      EXPECT_NEAR(pose.T_map_base.translation.y(), shift, 1e-12);
      EXPECT_NEAR(pose.T_map_base.translation.x(), 1.0 * pose.index, 1e-12);
    }
  }
}

TEST(KeyFrameTrack, TellsHowFarKeyFramesMove) {
  KeyFrameTrack track;
  for (KeyFrameIndex index = 0; index < 10; ++index) track.add(key_frame_at(index, 1.0 * index));
  EXPECT_NEAR(track.update(shifted(7, 1.0)), 1.0, 1e-12) << "odometry was there before";
  EXPECT_NEAR(track.update(shifted(7, -2.0)), 3.0, 1e-12);
  EXPECT_NEAR(track.update(shifted(9, -2.0)), 0.0, 1e-12) << "the last two were expected there";
  KeyFramePoses one = shifted(5, 0.5);
  one.whole = false;
  one.poses.erase(one.poses.begin(), one.poses.begin() + 5);
  EXPECT_NEAR(track.update(one), 2.5, 1e-12);
  EXPECT_EQ(KeyFrameTrack().update(shifted(7, 1.0)), 0.0) << "of none that is known";
}

// Entries may be missing in both lists; the others are associated by index.
TEST(KeyFrameTrack, AssociatesByIndexWithMissingEntries) {
  std::mt19937 random(4);
  for (int round = 0; round < 50; ++round) {
    KeyFrameTrack track;
    KeyFramePoses poses = shifted(19, 5.0);
    std::vector<KeyFramePose> remaining;
    for (KeyFrameIndex index = 0; index < 20; ++index) {
      if (random() % 4 != 0) track.add(key_frame_at(index, 1.0 * index));
      if (index == 0 || random() % 4 != 0) remaining.push_back(poses.poses[index]);
    }
    track.add(key_frame_at(0, 0.0));
    poses.poses = remaining;
    track.update(poses);
    for (const KeyFramePose& pose : track.poses().poses) {
      EXPECT_NEAR(pose.T_map_base.translation.x(), 1.0 * pose.index, 1e-12);
      EXPECT_NEAR(pose.T_map_base.translation.y(), 5.0, 1e-12);
    }
  }
}

// Stamps and indices are those of the key frames.
TEST(KeyFrameTrack, KeepsStampsAndIndices) {
  KeyFrameTrack track;
  track.add(key_frame_at(3, 1.0));
  track.update(shifted(7, 1.0));
  ASSERT_EQ(track.poses().poses.size(), 1U);
  EXPECT_EQ(track.poses().poses[0].stamp, 300);
  EXPECT_EQ(track.poses().poses[0].index, 3U);
}

TEST(KeyFrameTrack, OdometryStartsAtTheFirstPoseOfTheMap) {
  KeyFrameTrack track;
  for (KeyFrameIndex index = 0; index < 5; ++index) track.add(key_frame_at(index, 1.1 * index));
  track.update(shifted(4, 2.0));
  const KeyFramePoses odometry = track.odometry();
  EXPECT_NEAR(odometry.poses[0].T_map_base.translation.y(), 2.0, 1e-12);
  EXPECT_NEAR(odometry.poses[4].T_map_base.translation.x(), 4.4, 1e-12);
}

// Each segment has an odometry of its own, which begins somewhere else.
TEST(KeyFrameTrack, OdometryBeginsAnewInEachSegment) {
  KeyFrameTrack track;
  for (KeyFrameIndex index = 0; index < 6; ++index) {
    KeyFrame key_frame = key_frame_at(index, index < 3 ? 1.1 * index : 500.0 + 1.1 * (index - 3));
    key_frame.segment = index / 3;
    track.add(key_frame);
  }
  track.update(shifted(5, 2.0));
  const KeyFramePoses odometry = track.odometry();
  EXPECT_NEAR(odometry.poses[2].T_map_base.translation.x(), 2.2, 1e-12);
  EXPECT_NEAR(odometry.poses[3].T_map_base.translation.x(), 3.0, 1e-12);
  EXPECT_NEAR(odometry.poses[5].T_map_base.translation.x(), 5.2, 1e-9);
  EXPECT_NEAR(odometry.poses[5].T_map_base.translation.y(), 2.0, 1e-12);
}

}  // namespace
}  // namespace lidar_mapping::map
