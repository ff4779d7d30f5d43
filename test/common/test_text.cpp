// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping {
namespace {

TEST(Text, FormatsLikePrintf) {
  EXPECT_EQ(formatted("%.2f m in %zu of %s", 1.5, std::size_t{3}, "ten"), "1.50 m in 3 of ten");
  EXPECT_EQ(formatted("%s", ""), "");
}

TEST(Text, CutsNothingOff) {
  const std::string word(5000, 'x');
  EXPECT_EQ(formatted("%s!", word.c_str()), word + "!");
}

TEST(Text, JoinsWithASeparator) {
  EXPECT_EQ(joined({}), "");
  EXPECT_EQ(joined({"pcd"}), "pcd");
  EXPECT_EQ(joined({"pcd", "ply", "las"}), "pcd, ply, las");
  EXPECT_EQ(joined({"one", "two"}, "\n"), "one\ntwo");
}

TEST(Text, CountsOneAndSeveral) {
  EXPECT_EQ(counted(0, "loop"), "0 loops");
  EXPECT_EQ(counted(1, "key frame"), "1 key frame");
  EXPECT_EQ(counted(2, "key frame"), "2 key frames");
}

TEST(Text, IsOneOfSeveral) {
  EXPECT_TRUE(contains({"pcd", "ply"}, "ply"));
  EXPECT_FALSE(contains({"pcd", "ply"}, "las"));
  EXPECT_FALSE(contains({}, ""));
}

TEST(Text, LowerCase) { EXPECT_EQ(lower_case("GemanMcClure 2_A"), "gemanmcclure 2_a"); }

TEST(Text, IsQuotedWithItsOwnMarksDoubled) {
  EXPECT_EQ(quoted("", '"'), "\"\"");
  EXPECT_EQ(quoted("far, \"too\" far", '"'), "\"far, \"\"too\"\" far\"");
  EXPECT_EQ(quoted("it's \"a\"", '\''), "'it''s \"a\"'");
}

TEST(Text, NumbersInNamesAreOrderedByTheirValue) {
  const std::vector<std::string> ordered = {"",
                                            "0.bin",
                                            "01.bin",
                                            "1.bin",
                                            "2.bin",
                                            "10.25.bin",
                                            "10.5.bin",
                                            "10.bin",
                                            "10a.bin",
                                            "scan.bin",
                                            "scan9",
                                            "scan10",
                                            "scan10_1",
                                            "scan10_02",
                                            "scan10_3",
                                            "scan0011",
                                            "scan99999999999999999999"};
  std::vector<std::string> names = ordered;
  std::rotate(names.begin(), names.begin() + 7, names.end());
  std::reverse(names.begin(), names.begin() + 5);
  std::sort(names.begin(), names.end(), in_order_of_numbers);
  EXPECT_EQ(names, ordered);
  EXPECT_TRUE(in_order_of_numbers("9.pcd", "10.pcd"));
  EXPECT_TRUE(in_order_of_numbers("000009.pcd", "000010.pcd"));
  EXPECT_TRUE(in_order_of_numbers("1317617735.25.pcd", "1317617735.5.pcd")) << "decimals";
  EXPECT_TRUE(in_order_of_numbers("drive_9.bag", "drive_10.bag"));
  EXPECT_TRUE(in_order_of_numbers("01.bin", "1.bin")) << "the same number";
  EXPECT_FALSE(in_order_of_numbers("7.bin", "7.bin"));
}

TEST(Text, SecondsHaveAllDigitsOfTheStamp) {
  EXPECT_EQ(seconds_text(1'700'000'000'000'000'005), "1700000000.000000005");
  EXPECT_EQ(seconds_text(0), "0.000000000");
  EXPECT_EQ(seconds_text(-5), "-0.000000005");
}

}  // namespace
}  // namespace lidar_mapping
