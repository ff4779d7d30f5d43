// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/csv.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping {
namespace {

using Cells = std::vector<std::string>;

TEST(CsvCells, AreWhatLiesBetweenCommas) {
  EXPECT_EQ(csv_cells("1,elevation, 2.5 \r"), (Cells{"1", "elevation", " 2.5 \r"}));
  EXPECT_EQ(csv_cells("one"), Cells{"one"});
}

TEST(CsvCells, MayBeEmpty) {
  EXPECT_EQ(csv_cells(""), Cells{""});
  EXPECT_EQ(csv_cells(",a,,"), (Cells{"", "a", "", ""}));
  EXPECT_EQ(csv_cells("a,\"\""), (Cells{"a", ""}));
}

TEST(CsvCells, HaveCommasAndQuotesBetweenQuotes) {
  EXPECT_EQ(csv_cells("1,\"lost, and found\",2"), (Cells{"1", "lost, and found", "2"}));
  EXPECT_EQ(csv_cells("\"a \"\"b\"\", c\",d"), (Cells{"a \"b\", c", "d"}));
  EXPECT_EQ(csv_cells("\"never closed, 2"), Cells{"never closed, 2"});
}

TEST(CsvCells, GiveBackAQuotedText) {
  for (const std::string text : {"", "a", "a,b", "\"", "\"\"", "say \"a, b\"", "it's"}) {
    EXPECT_EQ(csv_cells(quoted(text, '"') + ",x"), (Cells{text, "x"}));
  }
}

}  // namespace
}  // namespace lidar_mapping
