// SPDX-License-Identifier: BSD-3-Clause
// A map with true poses is never reported as passes that lie apart, whatever the world.
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/map_quality/map_quality.hpp"

#include "simulated_key_frames.hpp"

namespace lidar_mapping::map_quality {
namespace {

/// Key frames of a drive that comes back to places, with 16 beams.
class Revisits {
 public:
  explicit Revisits(const std::string& name, double spacing = 3.0)
      : drive_(options(name)), frames(drive_, 0.0, 1e6, spacing) {
    config.p_base_sensor = drive_.mounting().T_base_lidar.translation;
  }

  std::vector<GhostVector> ghosts() { return ghost_vectors(frames.poses, frames, config); }

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

/// Far below what the report calls worth a look.
void expect_no_alarm(const std::vector<GhostVector>& ghosts) {
  for (const GhostVector& ghost : ghosts) {
    EXPECT_LT(std::hypot(ghost.left, ghost.up), 0.03) << ghost.key_frame;
    EXPECT_LT(std::abs(ghost.along), 0.1) << ghost.key_frame;
    EXPECT_LT(std::abs(ghost.yaw), 0.1 * M_PI / 180.0) << ghost.key_frame;
  }
}

class TrueMap : public testing::TestWithParam<const char*> {};

TEST_P(TrueMap, HasNoPassesThatLieApart) { expect_no_alarm(Revisits(GetParam()).ghosts()); }

INSTANTIATE_TEST_SUITE_P(Worlds, TrueMap, testing::Values("open_road", "tunnel", "walk"));

// The upper side of a slab is no displaced lower side, what lies on another storey is another
// place, and a car in a row is not the next one. What is displaced is found all the same.
TEST(CarPark, OnlyADisplacedPassIsFound) {
  constexpr KeyFrameIndex kSecondRound = 100;
  constexpr double kAside = 0.05;  // m
  constexpr double kUp = 0.03;     // m
  Revisits drive("car_park");
  const auto ghosts = drive.ghosts();
  EXPECT_GE(ghosts.size(), 20U);
  expect_no_alarm(ghosts);

  for (KeyFramePose& pose : drive.frames.poses.poses) {
    if (pose.index < kSecondRound) continue;
    pose.T_map_base.translation += Eigen::Vector3d(kAside, kAside, kUp);
  }
  std::size_t found = 0;
  for (const GhostVector& ghost : drive.ghosts()) {
    if (ghost.key_frame < 110 || ghost.key_frame > 140) continue;  // passes behind the other round
    EXPECT_NEAR(std::hypot(ghost.along, ghost.left), std::hypot(kAside, kAside), 0.01);
    EXPECT_NEAR(ghost.up, kUp, 0.01);
    ++found;
  }
  EXPECT_GE(found, 5U);
}

}  // namespace
}  // namespace lidar_mapping::map_quality
