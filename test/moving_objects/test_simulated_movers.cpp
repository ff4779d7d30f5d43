// SPDX-License-Identifier: BSD-3-Clause
// Moving cars of a simulated drive go, and what stands stays.
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include "simulated_key_frames.hpp"

namespace lidar_mapping::moving_objects {
namespace {

struct Shares {
  double moving_removed = 0.0;
  double standing_lost = 0.0;
};

/// A street with a car ahead and traffic, with noisy poses.
Shares shares_of(const std::string& lidar, std::size_t thinning, double sigma_m, double sigma_deg,
                 std::uint64_t seed = 1) {
  simulation::DriveOptions options;
  options.undistorted = true;
  options.lidar = lidar;
  options.seed = seed;
  options.duration = 27.0;
  const simulation::Drive drive(options);
  test::SimulatedKeyFrames frames(drive, 5.0, 26.0, 2.0, thinning);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (KeyFramePose& pose : frames.poses.poses) {
    Vector6d slip;
    for (int i = 0; i < 6; ++i) {
      slip[i] = normal(random) * (i < 3 ? sigma_m : sigma_deg * M_PI / 180.0);
    }
    pose.T_map_base = perturbed(pose.T_map_base, slip);
  }
  StaticClouds fixed(frames, frames.poses, drive.mounting().T_base_lidar.translation);
  double moving = 0.0;
  double moving_kept = 0.0;
  double standing = 0.0;
  double standing_kept = 0.0;
  // Key frames at the ends have observers on one side only.
  const std::size_t count = frames.poses.poses.size();
  for (std::size_t k = 10; k + 10 < count; ++k) {
    const KeyFrameIndex index = frames.poses.poses[k].index;
    const PointCloudPtr all = frames.cloud(index);
    const PointCloudPtr kept = fixed.cloud(index);
    std::size_t next = 0;
    for (std::size_t i = 0; i < all->size(); ++i) {
      const bool stays =
          next < kept->size() && kept->points[next].position() == all->points[i].position();
      if (stays) ++next;
      const bool moves = frames.moving(index)[i] != 0;
      (moves ? moving : standing) += 1.0;
      if (stays) (moves ? moving_kept : standing_kept) += 1.0;
    }
  }
  EXPECT_GT(moving, 1000.0);
  return {1.0 - moving_kept / moving, 1.0 - standing_kept / standing};
}

TEST(SimulatedMovers, GoWithSixtyFourBeams) {
  const Shares shares = shares_of("hdl64", 4, 0.0, 0.0);
  EXPECT_GT(shares.moving_removed, 0.96);
  EXPECT_LT(shares.standing_lost, 0.001);
}

TEST(SimulatedMovers, GoWithSixteenBeams) {
  const Shares shares = shares_of("vlp16", 1, 0.0, 0.0);
  EXPECT_GT(shares.moving_removed, 0.95);
  EXPECT_LT(shares.standing_lost, 0.001);
}

// Its traffic stays far ahead, where a key frame and its neighbours see cars and no ground below.
TEST(SimulatedMovers, GoFarAheadWithSixteenBeams) {
  EXPECT_GT(shares_of("vlp16", 1, 0.0, 0.0, 4).moving_removed, 0.875);
}

// A longer part of that drive loses a quarter more, and 0.2 % is what may go.
TEST(SimulatedMovers, GroundStaysWhereSixteenBeamsHaveErrorsOfPose) {
  EXPECT_LT(shares_of("vlp16", 1, 0.05, 0.1, 3).standing_lost, 0.0016);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
