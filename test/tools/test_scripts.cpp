// SPDX-License-Identifier: BSD-3-Clause
// Scripts that measure the package: their tests are in Python, as they are.
#include <cstdlib>

#include <gtest/gtest.h>

/// Names of functions, files, topics and tests that the pages give.
TEST(Scripts, PagesNameWhatIsThere) {
  EXPECT_EQ(std::system("python3 ../scripts/check_names.py"), 0);
}

TEST(Scripts, FailedTestsAreShown) {
  EXPECT_EQ(std::system("python3 tools/check_count_tests.py"), 0);
}

TEST(Scripts, AblationIsRight) { EXPECT_EQ(std::system("python3 tools/check_ablate.py"), 0); }

TEST(Scripts, TheDemosSecondDriveIsRight) {
  EXPECT_EQ(std::system("python3 tools/check_second_drive.py"), 0);
}

TEST(Scripts, ABlockOfCommandsThatIsRunAgainBeginsWhereItBegan) {
  EXPECT_EQ(std::system("python3 tools/check_snapshot.py"), 0);
}

TEST(Scripts, TheSetupLetsOtherComputersReachTheNodes) {
  EXPECT_EQ(std::system("python3 tools/check_setup.py"), 0);
}
