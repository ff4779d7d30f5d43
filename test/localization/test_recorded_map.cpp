// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include <gtest/gtest.h>

#include "lidar_mapping/localization/localizer.hpp"

#include "recorded_scans.hpp"
#include "test_data.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::RecordedClouds;

struct Outcome {
  int posed = 0;   ///< scans with a pose
  int wrong = 0;   ///< of them off by more than a metre or two degrees
  int first = -1;  ///< index of the first scan with a pose
};

struct RecordedDrive {
  std::filesystem::path folder;
  std::vector<Pose> truth = lidar_mapping::test::recorded_poses(folder);
  std::vector<Stamp> stamps = lidar_mapping::test::recorded_stamps(folder);
};

/// Localises the key frames [first, last] as scans, without knowledge of the place of the first.
Outcome localise(MapIndex& map, const RecordedDrive& drive, std::size_t first, std::size_t last) {
  RecordedClouds clouds(drive.folder);
  Localizer localizer(map);
  Outcome outcome;
  for (std::size_t i = first; i <= last; ++i) {
    LocalizerInput input;
    input.scan = {drive.stamps.at(i), *clouds.cloud(static_cast<KeyFrameIndex>(i))};
    if (i > first) input.T_previous_base = drive.truth[i - 1].inverse() * drive.truth[i];
    input.covariance = diagonal_covariance(0.05, 0.003);
    const LocalizationResult result = localizer.process(input);
    if (!has_pose(result.state)) continue;
    if (outcome.first < 0) outcome.first = static_cast<int>(i);
    const Vector6d error = difference(drive.truth[i], result.T_map_base);
    ++outcome.posed;
    outcome.wrong += error.head<3>().norm() > 1.0 || error.tail<3>().norm() > 0.035 ? 1 : 0;
  }
  std::printf("key frames %zu to %zu: first pose at %d, %d poses, %d wrong\n", first, last,
              outcome.first, outcome.posed, outcome.wrong);
  return outcome;
}

TEST(RecordedMap, IsRecognisedOnlyWhereTheDriveReturns) {
  REQUIRE_RECORDED(folder, "kitti00_keyframes");
  const RecordedDrive drive = {folder};
  RecordedClouds clouds(folder);
  MapIndex map(source_of({drive.truth.begin(), drive.truth.begin() + 601}, Eigen::Vector3d::Zero()),
               clouds, {});
  const Outcome again = localise(map, drive, 617, 655);
  EXPECT_GE(again.first, 617);
  EXPECT_LE(again.first, 622);
  EXPECT_GE(again.posed, 34);
  const Outcome at_the_end = localise(map, drive, 987, 1004);
  EXPECT_GE(at_the_end.posed, 8);
  EXPECT_EQ(again.wrong + at_the_end.wrong, 0);
  EXPECT_EQ(localise(map, drive, 700, 730).posed, 0);  // a street that the map lacks
}

}  // namespace
}  // namespace lidar_mapping::localization::test
