// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "mapping/mapping_figures.hpp"

namespace lidar_mapping::tools {
namespace {

constexpr RunTimes kTimes = {1.0, 2.0, 3.0, 4.0, 7.0};

TEST(MappingFigures, NameWhatWasLeftOut) {
  pipeline::PipelineReport report;
  report.scans_unreadable = 2;
  report.scans_before_newest = 3;
  report.counters.scans_out_of_order = 4;
  report.counters.gnss_refused = 5;
  const json::Json figures = mapping_figures(report, 60.0, kTimes);
  EXPECT_EQ(figures["left_out"]["scans out of order"], 7);
  const std::string text = to_text(figures);
  for (const char* words : {"2 scans damaged", "7 scans out of order", "5 GNSS fixes"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in " << text;
  }
  EXPECT_EQ(text.find("samples of IMU"), std::string::npos) << text;
}

TEST(MappingFigures, DoNotMentionWhatWasNotLeftOut) {
  const std::string text = to_text(mapping_figures({}, 60.0, kTimes));
  EXPECT_EQ(text.find("left out"), std::string::npos) << text;
  EXPECT_NE(text.find("60 s of driving"), std::string::npos) << text;
}

}  // namespace
}  // namespace lidar_mapping::tools
