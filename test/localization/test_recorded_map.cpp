// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include <gtest/gtest.h>

#include "lidar_mapping/localization/localizer.hpp"

#include "recorded_scans.hpp"
#include "test_data.hpp"

namespace lidar_mapping::localization::test {
namespace {

/// Recorded key frames in the format of the KITTI benchmark.
class RecordedClouds : public CloudSource {
 public:
  explicit RecordedClouds(std::filesystem::path folder) : folder_(std::move(folder)) {}
  PointCloudPtr cloud(KeyFrameIndex index) override {
    return std::make_shared<PointCloud>(lidar_mapping::test::recorded_scan(folder_, index));
  }

 private:
  std::filesystem::path folder_;
};

MapSource source_of(const std::vector<Pose>& truth, std::size_t count) {
  MapSource source;
  for (std::size_t i = 0; i < count; ++i) {
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(i);
    key_frame.stamp = from_seconds(static_cast<double>(i));
    key_frame.T_odom_base = truth[i];
    source.key_frames.push_back(key_frame);
    source.poses.poses.push_back({key_frame.index, key_frame.stamp, truth[i]});
  }
  return source;
}

struct Outcome {
  int posed = 0;   ///< scans with a pose
  int wrong = 0;   ///< of them off by more than a metre or two degrees
  int first = -1;  ///< index of the first scan with a pose
};

/// Localises the key frames [first, last] as scans, without knowledge of the place of the first.
Outcome localise(MapIndex& map, RecordedClouds& clouds, const std::vector<Pose>& truth,
                 std::size_t first, std::size_t last) {
  Localizer localizer(map);
  Outcome outcome;
  for (std::size_t i = first; i <= last; ++i) {
    LocalizerInput input;
    input.scan = {from_seconds(static_cast<double>(i)),
                  *clouds.cloud(static_cast<KeyFrameIndex>(i))};
    if (i > first) input.T_previous_base = truth[i - 1].inverse() * truth[i];
    input.covariance = diagonal_covariance(0.05, 0.003);
    const LocalizationResult result = localizer.process(input);
    if (!has_pose(result.state)) continue;
    if (outcome.first < 0) outcome.first = static_cast<int>(i);
    const Vector6d error = difference(truth[i], result.T_map_base);
    ++outcome.posed;
    outcome.wrong += error.head<3>().norm() > 1.0 || error.tail<3>().norm() > 0.035 ? 1 : 0;
  }
  std::printf("key frames %zu to %zu: first pose at %d, %d poses, %d wrong\n", first, last,
              outcome.first, outcome.posed, outcome.wrong);
  return outcome;
}

TEST(RecordedMap, IsRecognisedWhereTheDriveComesAgainAndNowhereElse) {
  REQUIRE_RECORDED(folder, "kitti00_keyframes");
  const auto truth = lidar_mapping::test::recorded_poses(folder);
  RecordedClouds clouds(folder);
  MapIndex map(source_of(truth, 601), clouds, {});
  const Outcome along = localise(map, clouds, truth, 617, 655);
  EXPECT_GE(along.first, 617);
  EXPECT_LE(along.first, 629);
  EXPECT_GE(along.posed, 25);
  const Outcome at_the_end = localise(map, clouds, truth, 987, 1004);
  EXPECT_GE(at_the_end.posed, 1);
  EXPECT_EQ(along.wrong + at_the_end.wrong, 0);
  EXPECT_EQ(localise(map, clouds, truth, 700, 730).posed, 0);  // a street that the map lacks
}

}  // namespace
}  // namespace lidar_mapping::localization::test
