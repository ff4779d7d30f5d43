// SPDX-License-Identifier: BSD-3-Clause

#include <gtest/gtest.h>

#include "lidar_mapping/common/sorted_values.hpp"

namespace lidar_mapping {
namespace {

/// Key frames 3, 5 and 9 at the stamps 30, 50 and 90.
std::vector<KeyFramePose> three_poses() { return {{3, 30, {}}, {5, 50, {}}, {9, 90, {}}}; }

std::ptrdiff_t position_from(const std::vector<KeyFramePose>& poses, Stamp stamp) {
  return first_not_before(poses, stamp) - poses.begin();
}

TEST(SortedValues, FindTheFirstThatIsNotBeforeAStamp) {
  const std::vector<KeyFramePose> poses = three_poses();
  EXPECT_EQ(position_from(poses, -1), 0);
  EXPECT_EQ(position_from(poses, 30), 0) << "at the stamp itself";
  EXPECT_EQ(position_from(poses, 31), 1);
  EXPECT_EQ(position_from(poses, 90), 2);
  EXPECT_EQ(position_from(poses, 91), 3) << "the end";
  EXPECT_EQ(position_from({}, 1), 0);
}

TEST(SortedValues, FindTheFirstOfEqualStamps) {
  const std::vector<KeyFramePose> poses = {{0, 10, {}}, {1, 20, {}}, {2, 20, {}}};
  EXPECT_EQ(position_from(poses, 20), 1);
}

TEST(SortedValues, FindAnIndex) {
  std::vector<KeyFramePose> poses = three_poses();
  for (const KeyFrameIndex index : {3U, 5U, 9U}) {
    const auto found = find_index(poses, index);
    ASSERT_NE(found, poses.end()) << index;
    EXPECT_EQ(found->index, index);
  }
  for (const KeyFrameIndex index : {0U, 4U, 10U}) {
    EXPECT_EQ(find_index(poses, index), poses.end()) << index;
  }
  find_index(poses, 5)->stamp = 55;
  EXPECT_EQ(poses[1].stamp, 55) << "what is found may be changed";
  poses.clear();
  EXPECT_EQ(find_index(poses, 5), poses.end());
}

}  // namespace
}  // namespace lidar_mapping
