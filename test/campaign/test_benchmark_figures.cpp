// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include "benchmark_figures.hpp"

namespace lidar_mapping::campaign {
namespace {

using front_end::TrackingState;

/// Scans that took 1, 2, 3 ... ms, 1 m apart.
std::vector<ScanRecord> records(int count) {
  std::vector<ScanRecord> result;
  for (int i = 0; i < count; ++i) {
    ScanRecord record;
    record.stamp = from_seconds(0.1 * i);
    record.T_odom_base.translation.x() = i;
    record.wall_ms = i + 1.0;
    record.cpu_ms = 2.0 * (i + 1.0);
    result.push_back(record);
  }
  return result;
}

TEST(BenchmarkFigures, AreMeanMedianQuantileAndMaximum) {
  std::vector<ScanRecord> scans = records(100);
  std::reverse(scans.begin(), scans.end());
  const auto figures = figures_of(scans);
  EXPECT_EQ(figures["scans"], 100);
  EXPECT_DOUBLE_EQ(figures["mean_ms"], 50.5);
  EXPECT_DOUBLE_EQ(figures["median_ms"], 51.0);
  EXPECT_DOUBLE_EQ(figures["p95_ms"], 96.0);
  EXPECT_DOUBLE_EQ(figures["max_ms"], 100.0);
  EXPECT_DOUBLE_EQ(figures["cpu_ms"], 101.0);
}

TEST(BenchmarkFigures, CountStates) {
  std::vector<ScanRecord> scans = records(5);
  scans[1].status.state = TrackingState::kDegenerate;
  scans[2].status.state = TrackingState::kLost;
  scans[3].status.rescued = true;
  scans[2].status.repeated = true;
  scans[0].key_frame = scans[4].key_frame = true;
  const auto figures = figures_of(scans);
  EXPECT_EQ(figures["degenerate"], 1);
  EXPECT_EQ(figures["lost"], 1);
  EXPECT_EQ(figures["degraded"], 0);
  EXPECT_EQ(figures["rescued"], 1);
  EXPECT_EQ(figures["repeated"], 1);
  EXPECT_EQ(figures["key_frames"], 2);
}

TEST(BenchmarkFigures, StepsAreMeansOverAllScans) {
  std::vector<ScanRecord> scans = records(4);
  scans[0].status.step_seconds = {{"matching", 0.002}, {"insertion", 0.004}};
  scans[1].status.step_seconds = {{"matching", 0.006}};
  const auto figures = figures_of(scans);
  EXPECT_DOUBLE_EQ(figures["step_ms"]["matching"], 2.0);
  EXPECT_DOUBLE_EQ(figures["step_ms"]["insertion"], 1.0);
}

TEST(BenchmarkFigures, ErrorsAreInPercentOfThePathLength) {
  std::vector<evaluation::PosePair> pairs;
  for (const ScanRecord& r : records(300)) {
    Pose estimate = r.T_odom_base;
    estimate.translation *= 1.01;
    pairs.push_back({r.stamp, r.T_odom_base, estimate});
  }
  const auto errors = errors_of(pairs);
  EXPECT_NEAR(errors["translation_error_percent"], 1.0, 1e-6);
  EXPECT_NEAR(errors["rotation_error_deg_per_100m"], 0.0, 1e-6);
  EXPECT_EQ(errors["segment_lengths_m"].size(), 4U);  // 50, 100, 150, 200 m
}

TEST(BenchmarkFigures, CsvHasALinePerScan) {
  const std::string csv = to_csv(records(3));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(csv.find("2,200000000,3,6,tracking"), std::string::npos);
}

TEST(BenchmarkFigures, CsvHasAColumnPerStep) {
  std::vector<ScanRecord> scans = records(2);
  scans[1].status.step_seconds = {{"matching", 0.002}, {"dense sampling", 0.004}};
  const std::string csv = to_csv(scans);
  EXPECT_NE(csv.find(",rescued,matching_ms,dense_sampling_ms\n"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",0,0,0\n1,"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",0,2,4\n"), std::string::npos) << csv;
}

}  // namespace
}  // namespace lidar_mapping::campaign
