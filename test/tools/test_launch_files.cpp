// SPDX-License-Identifier: BSD-3-Clause
// roslaunch reads the files by its modules of Python; so do the tests.
#include <cstdlib>

#include <gtest/gtest.h>

TEST(LaunchFiles, PassTheirArgumentsOn) {
  EXPECT_EQ(std::system("python3 tools/check_launch.py"), 0);
}
