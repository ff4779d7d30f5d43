// SPDX-License-Identifier: BSD-3-Clause
// Scripts that measure the package: their tests are in Python, as they are.
#include <cstdlib>

#include <gtest/gtest.h>

TEST(Scripts, AblationIsRight) { EXPECT_EQ(std::system("python3 tools/check_ablate.py"), 0); }
