// SPDX-License-Identifier: BSD-3-Clause
// scripts/spoilt_recordings.py needs ROS's modules of Python; its tests are in Python, as it is.
#include <cstdlib>

#include <gtest/gtest.h>

TEST(SpoiltRecordings, EachVariantHasItsFault) {
  EXPECT_EQ(std::system("python3 tools/check_recording_faults.py"), 0);
}

TEST(SpoiltRecordings, AreJudgedAndCounted) {
  EXPECT_EQ(std::system("python3 tools/check_spoilt_recordings.py"), 0);
}
