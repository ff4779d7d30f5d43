// SPDX-License-Identifier: BSD-3-Clause
// A map with true poses is never reported as misaligned, in any of the worlds.
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "simulated_key_frames.hpp"

namespace lidar_mapping::map_quality {
namespace {

/// Key frames of a drive with 16 beams that returns to known locations.
class RevisitingDrive {
 public:
  explicit RevisitingDrive(const std::string& name, double spacing = 3.0)
      : drive_(options(name)), frames(drive_, 0.0, 1e6, spacing) {
    config.p_base_sensor = drive_.mounting().T_base_lidar.translation;
  }

  std::vector<PassMisalignment> misalignments() {
    return pass_misalignments(frames.poses, frames, config);
  }

 private:
  static simulation::DriveOptions options(const std::string& name) {
    simulation::DriveOptions options;
    options.drive = name;
    options.lidar = "vlp16";
    options.undistorted = true;
    return options;
  }
  simulation::Drive drive_;

 public:
  test::SimulatedKeyFrames frames;
  QualityConfig config;
};

/// The misalignments are far below the limits of the report.
void expect_below_limits(const std::vector<PassMisalignment>& misalignments) {
  for (const PassMisalignment& misalignment : misalignments) {
    EXPECT_LT(std::hypot(misalignment.left, misalignment.up), 0.03) << misalignment.key_frame;
    EXPECT_LT(std::abs(misalignment.forward), 0.1) << misalignment.key_frame;
    EXPECT_LT(std::abs(misalignment.yaw), 0.1 * kRadPerDeg) << misalignment.key_frame;
  }
}

class TrueMap : public testing::TestWithParam<const char*> {};

TEST_P(TrueMap, HasNoMisalignedPasses) {
  expect_below_limits(RevisitingDrive(GetParam()).misalignments());
}

INSTANTIATE_TEST_SUITE_P(Worlds, TrueMap, testing::Values("open_road", "tunnel", "walk"));

// The two sides of a slab are not matched, storeys are separate locations, and a parked car is not
// matched with its neighbour. A real displacement is found nevertheless.
TEST(CarPark, OnlyDisplacedPassIsReported) {
  constexpr KeyFrameIndex kSecondRound = 100;
  constexpr double kSideways = 0.05;  // m
  constexpr double kUp = 0.03;        // m
  RevisitingDrive drive("car_park");
  const auto misalignments = drive.misalignments();
  EXPECT_GE(misalignments.size(), 20U);
  expect_below_limits(misalignments);

  for (KeyFramePose& pose : drive.frames.poses.poses) {
    if (pose.index < kSecondRound) continue;
    pose.T_map_base.translation += Eigen::Vector3d(kSideways, kSideways, kUp);
  }
  std::size_t found = 0;
  for (const PassMisalignment& misalignment : drive.misalignments()) {
    if (misalignment.key_frame < 110 || misalignment.key_frame > 140)
      continue;  // passes behind the other round
    EXPECT_NEAR(std::hypot(misalignment.forward, misalignment.left),
                std::hypot(kSideways, kSideways), 0.01);
    EXPECT_NEAR(misalignment.up, kUp, 0.01);
    ++found;
  }
  EXPECT_GE(found, 5U);
}

}  // namespace
}  // namespace lidar_mapping::map_quality
