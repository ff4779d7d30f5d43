// SPDX-License-Identifier: BSD-3-Clause
// Moving cars of a simulated drive are removed, and static points stay.
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include "simulated_key_frames.hpp"

namespace lidar_mapping::moving_objects {
namespace {

struct Fractions {
  double moving_removed = 0.0;
  double static_removed = 0.0;
};

/// Fractions for a street with a car ahead and traffic, with noisy poses.
Fractions measure_fractions(const std::string& lidar, std::size_t thinning, double sigma_m,
                            double sigma_deg, std::uint64_t seed = 1) {
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
    Vector6d pose_error;
    for (int i = 0; i < 6; ++i) {
      pose_error[i] = normal(random) * (i < 3 ? sigma_m : sigma_deg * M_PI / 180.0);
    }
    pose.T_map_base = perturbed(pose.T_map_base, pose_error);
  }
  StaticClouds static_clouds(frames, frames.poses, drive.mounting().T_base_lidar.translation);
  double moving = 0.0;
  double moving_kept = 0.0;
  double static_points = 0.0;
  double static_kept = 0.0;
  // Key frames at the ends have observers on one side only.
  const std::size_t count = frames.poses.poses.size();
  for (std::size_t k = 10; k + 10 < count; ++k) {
    const KeyFrameIndex index = frames.poses.poses[k].index;
    const PointCloudPtr all = frames.cloud(index);
    const PointCloudPtr kept = static_clouds.cloud(index);
    std::size_t next = 0;
    for (std::size_t i = 0; i < all->size(); ++i) {
      const bool is_kept =
          next < kept->size() && kept->points[next].position() == all->points[i].position();
      if (is_kept) ++next;
      const bool is_moving = frames.moving(index)[i] != 0;
      (is_moving ? moving : static_points) += 1.0;
      if (is_kept) (is_moving ? moving_kept : static_kept) += 1.0;
    }
  }
  EXPECT_GT(moving, 1000.0);
  return {1.0 - moving_kept / moving, 1.0 - static_kept / static_points};
}

TEST(SimulatedMovers, AreRemovedWithSixtyFourBeams) {
  const Fractions fractions = measure_fractions("hdl64", 4, 0.0, 0.0);
  EXPECT_GT(fractions.moving_removed, 0.96);
  EXPECT_LT(fractions.static_removed, 0.001);
}

TEST(SimulatedMovers, AreRemovedWithSixteenBeams) {
  const Fractions fractions = measure_fractions("vlp16", 1, 0.0, 0.0);
  EXPECT_GT(fractions.moving_removed, 0.95);
  EXPECT_LT(fractions.static_removed, 0.001);
}

// The traffic of this drive stays far ahead, where a key frame and its neighbours observe cars and
// no ground below.
TEST(SimulatedMovers, AreRemovedFarAheadWithSixteenBeams) {
  EXPECT_GT(measure_fractions("vlp16", 1, 0.0, 0.0, 4).moving_removed, 0.875);
}

// A longer part of that drive loses a quarter more; the limit is 0.2 %.
TEST(SimulatedMovers, GroundStaysDespitePoseErrorsWithSixteenBeams) {
  EXPECT_LT(measure_fractions("vlp16", 1, 0.05, 0.1, 3).static_removed, 0.0016);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
