// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/back_end/pose_change.hpp"

namespace lidar_mapping::back_end {
namespace {

/// Key frames along x, moved along y by their entries of `shifts`.
KeyFramePoses moved(KeyFrameIndex first, const std::vector<double>& shifts) {
  KeyFramePoses poses;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const KeyFrameIndex index = first + static_cast<KeyFrameIndex>(i);
    Pose pose;
    pose.translation = {1.0 * index, shifts[i], 0.0};
    poses.poses.push_back({index, 100 * Stamp{index}, pose});
  }
  return poses;
}

TEST(PoseChange, ComparesTheKeyFramesInBothStates) {
  const PoseChange change =
      change_between(moved(0, {9.0, 0.0, 0.0, 0.0}), moved(1, {0.5, -2.0, 0.5, 7.0}));
  EXPECT_EQ(change.key_frames, 3U);
  EXPECT_NEAR(change.mean, 1.0, 1e-12);
  EXPECT_NEAR(change.largest, 2.0, 1e-12);
  EXPECT_EQ(change.farthest, 2U);
  EXPECT_EQ(change.stamp, 200);
}

TEST(PoseChange, IsZeroWithoutMotionOrKeyFrames) {
  const KeyFramePoses poses = moved(3, {1.0, 2.0});
  EXPECT_EQ(change_between(poses, poses).largest, 0.0);
  EXPECT_EQ(change_between(poses, poses).farthest, 3U);
  EXPECT_EQ(change_between({}, poses).key_frames, 0U);
  EXPECT_EQ(change_between({}, poses).mean, 0.0);
}

}  // namespace
}  // namespace lidar_mapping::back_end
