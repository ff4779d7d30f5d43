// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/scan_merging.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr Stamp kStart = 1'000'000'000;  // ns

Stamp stamp(double seconds) { return kStart + from_seconds(seconds); }

/// Points a hundredth of a second apart, whose intensities are their times since kStart in s.
RawScan scan(double begin, const std::string& frame, double first = 0.0, int count = 10) {
  RawScan scan;
  scan.stamp = stamp(begin);
  scan.frame_id = frame;
  for (int i = 0; i < count; ++i) {
    const double time = first + 0.01 * i;
    scan.cloud.points.push_back({1.0F, 2.0F, 3.0F, static_cast<float>(begin + time)});
    scan.cloud.times.push_back(static_cast<float>(time));
  }
  return scan;
}

/// Times (s) of the points from another LiDAR, which come last.
std::vector<float> times_of_others(const RawScan& scan) {
  return {scan.cloud.times.begin() + 10, scan.cloud.times.end()};
}

const PassLimits kLimits{PreprocessingConfig{}};

/// Two poses of which the second is known in the first by hand.
const Pose kTurned{exp_so3({0.0, 0.0, 1.5707963267948966}), {5.0, 0.0, 1.0}};

TEST(ScanMerging, PointsOfTheScansTimeAreMovedAndAppended) {
  RawScan main = scan(0.0, "main");
  EXPECT_EQ(append_points(main, scan(0.045, "other"), kTurned, kLimits), 5U);
  ASSERT_EQ(main.cloud.size(), 15U);
  ASSERT_EQ(main.cloud.times.size(), 15U);
  for (std::size_t i = 10; i < 15; ++i) {
    const Point& p = main.cloud.points[i];
    EXPECT_NEAR(p.x, 5.0 - 2.0, 1e-5);
    EXPECT_NEAR(p.y, 1.0, 1e-5);
    EXPECT_NEAR(p.z, 4.0, 1e-5);
    EXPECT_NEAR(main.cloud.times[i], p.intensity, 1e-6);
  }
  // A scan that is stamped at its end.
  EXPECT_EQ(append_points(main, scan(0.145, "other", -0.1), kTurned, kLimits), 5U);
  EXPECT_EQ(append_points(main, scan(0.2, "other"), kTurned, kLimits), 0U);
}

TEST(ScanMerging, WithoutTimesNothingIsAppended) {
  RawScan main = scan(0.0, "main"), other = scan(0.0, "other");
  other.cloud.times.clear();
  EXPECT_EQ(append_points(main, other, {}, kLimits), 0U);
  main.cloud.times.clear();
  EXPECT_EQ(append_points(main, scan(0.0, "other"), {}, kLimits), 0U);
  EXPECT_EQ(main.cloud.size(), 10U);
}

// Rays without a return would become points at the place of the other LiDAR.
TEST(ScanMerging, TheRangeIsThatFromTheOtherLidar) {
  PreprocessingConfig config;
  config.distance_near_thresh = 2.0;
  config.distance_far_thresh = 20.0;
  const PassLimits limits(config);
  RawScan other = scan(0.0, "other");
  for (Point& point : other.cloud.points) point.x = point.y = point.z = 0.0F;
  other.cloud.points[3] = {1.9F, 0.0F, 0.0F, 3.0F};
  other.cloud.points[4] = {2.1F, 0.0F, 0.0F, 4.0F};
  other.cloud.points[5] = {0.0F, 19.9F, 0.0F, 5.0F};
  other.cloud.points[6] = {0.0F, 20.1F, 0.0F, 6.0F};
  RawScan main = scan(0.0, "main");
  EXPECT_EQ(append_points(main, other, kTurned, limits), 2U);
  ASSERT_EQ(main.cloud.size(), 12U);
  EXPECT_EQ(main.cloud.points[10].intensity, 4.0F);
  EXPECT_EQ(main.cloud.points[11].intensity, 5.0F);
  config.use_distance_filter = false;
  EXPECT_EQ(append_points(main, other, kTurned, PassLimits(config)), 4U) << "all with a return";
}

TEST(ScanMerger, AloneNothingWaits) {
  ScanMerger merger{PreprocessingConfig{}};
  for (int i = 0; i < 5; ++i) {
    const auto complete = merger.add(scan(0.1 * i, "main"), {});
    ASSERT_EQ(complete.size(), 1U);
    EXPECT_EQ(complete[0].stamp, stamp(0.1 * i));
  }
  EXPECT_FALSE(merger.flush());
}

TEST(ScanMerger, AScanHasThePointsOfAllOthersOfItsTimeOnce) {
  ScanMerger merger{PreprocessingConfig{}};
  std::vector<RawScan> complete;
  const auto take = [&](std::vector<RawScan> scans) {
    for (RawScan& scan : scans) complete.push_back(std::move(scan));
  };
  for (int i = 0; i < 6; ++i) {
    merger.add_other(scan(0.1 * i + 0.035, "a"), {});
    merger.add_other(scan(0.1 * i + 0.1, "b", -0.1), {});  // stamped at its end
    take(merger.add(scan(0.1 * i, "main"), {}));
  }
  ASSERT_EQ(complete.size(), 5U);
  take({*merger.flush()});
  EXPECT_FALSE(merger.flush());
  for (std::size_t i = 1; i < complete.size(); ++i) {
    EXPECT_EQ(complete[i].stamp, stamp(0.1 * static_cast<double>(i)));
    std::vector<float> times = times_of_others(complete[i]);
    EXPECT_GE(times.size(), 18U) << i;  // but those at the border of two scans
    EXPECT_LE(times.size(), 20U) << i;
    for (const float time : times) {
      EXPECT_GE(time, 0.0F);
      EXPECT_LE(time, 0.09F + 1e-6F);
    }
  }
}

TEST(ScanMerger, AMissingOtherDelaysOneScanOnly) {
  ScanMerger merger{PreprocessingConfig{}};
  merger.add_other(scan(0.0, "other"), {});
  EXPECT_TRUE(merger.add(scan(0.0, "main"), {}).empty());
  EXPECT_EQ(merger.add(scan(0.1, "main"), {}).size(), 1U);
  EXPECT_EQ(merger.add(scan(0.2, "main"), {}).size(), 1U);
  EXPECT_EQ(merger.add(scan(0.3, "main"), {}).size(), 2U);  // it is not waited for any more
  EXPECT_EQ(merger.add(scan(0.4, "main"), {}).size(), 1U);
}

// A recording that starts again. Scans of the time before must not hide those of the new one.
TEST(ScanMerger, GoesOnWhenTimeGoesBack) {
  ScanMerger merger{PreprocessingConfig{}};
  for (const double start : {100.0, 0.0}) {
    for (int i = 0; i < 5; ++i) {
      merger.add_other(scan(start + 0.1 * i, "other"), {});
      merger.add(scan(start + 0.1 * i, "main"), {});
    }
    const auto last = merger.flush();
    ASSERT_TRUE(last) << start;
    EXPECT_EQ(last->cloud.size(), 20U) << start;
  }
}

TEST(ScanMerger, PlacesAreThoseOnTheVehicle) {
  ScanMerger merger{PreprocessingConfig{}};
  const Pose T_base_main{exp_so3({0.1, 0.2, 0.3}), {1.0, 0.0, 2.0}};
  merger.add_other(scan(0.0, "other"), T_base_main * kTurned);
  merger.add(scan(0.0, "main"), T_base_main);
  const auto merged = merger.flush();
  ASSERT_TRUE(merged);
  ASSERT_EQ(merged->cloud.size(), 20U);
  EXPECT_NEAR(merged->cloud.points.back().x, 3.0, 1e-5);
  EXPECT_NEAR(merged->cloud.points.back().z, 4.0, 1e-5);
}

// A driver that hangs repeats its own points, not those of another one.
TEST(ScanMerging, TheFingerprintIsThatOfTheMainLidar) {
  RawScan alone = scan(0.0, "main", 0.0, 40), main = alone;
  for (RawScan* raw : {&alone, &main})
    for (Point& point : raw->cloud.points) point.x += point.intensity;
  RawScan other = scan(0.0, "other");
  alone.take_fingerprint();
  ASSERT_TRUE(alone.fingerprint);
  EXPECT_EQ(append_points(main, other, kTurned, kLimits), 10U);
  main.take_fingerprint();
  EXPECT_EQ(main.fingerprint, alone.fingerprint);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
