// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include "map_noise.hpp"

namespace lidar_mapping::localization {
namespace {

/// Metres of a way, each with a match in a map whose surfaces are off by these standard deviations.
class NoisyMap {
 public:
  NoisyMap(double stddev, double stddev_angle) : stddev_(stddev), stddev_angle_(stddev_angle) {}

  void drive(MapNoise& noise, int metres, bool in_map = true) {
    Pose step;
    step.translation = Eigen::Vector3d::UnitX();
    step.rotation = exp_so3({0.0, 0.0, 0.01});
    for (int i = 0; i < metres; ++i) {
      T_map_base_ = T_map_base_ * step;
      noise.move(step);
      if (in_map) noise.add_match(match());
    }
  }

  /// Where the vehicle is thought to be from now on.
  void displace(const Pose& T_base_displaced) { T_map_base_ = T_map_base_ * T_base_displaced; }

 private:
  Pose match() {
    Pose error;
    error.translation = stddev_ * random();
    error.rotation = exp_so3(stddev_angle_ * random());
    return T_map_base_ * error;
  }
  Eigen::Vector3d random() { return {normal_(engine_), normal_(engine_), normal_(engine_)}; }

  double stddev_, stddev_angle_;
  Pose T_map_base_;
  std::mt19937 engine_{5};
  std::normal_distribution<double> normal_;
};

TEST(MapNoise, IsAssumedBeforeAnythingWasDriven) {
  const MapNoise noise;
  EXPECT_NEAR(noise.stddev(), 0.02, 1e-12);
  EXPECT_NEAR(noise.stddev_angle(), 9e-4, 1e-12);
}

TEST(MapNoise, IsThatOfTheMapAfterSomeDistance) {
  for (const double stddev : {0.005, 0.03, 0.1}) {
    MapNoise noise;
    NoisyMap(stddev, 0.1 * stddev).drive(noise, 200);
    // Attitude errors at the begin move the end of ten metres sideways, up and down.
    EXPECT_NEAR(noise.stddev(), stddev * std::sqrt(1.0 + 1.0 / 3.0), 0.2 * stddev) << stddev;
    EXPECT_NEAR(noise.stddev_angle(), 0.1 * stddev, 0.02 * stddev) << stddev;
  }
}

TEST(MapNoise, HasALeastValue) {
  MapNoise noise;
  NoisyMap(0.0, 0.0).drive(noise, 3000);
  EXPECT_NEAR(noise.stddev(), 0.002, 1e-4);
  EXPECT_NEAR(noise.stddev_angle(), 1e-4, 1e-5);
}

TEST(MapNoise, FollowsAMapThatGetsWorse) {
  MapNoise noise;
  NoisyMap(0.003, 3e-4).drive(noise, 300);
  NoisyMap worse(0.05, 5e-3);
  noise.interrupt();
  worse.drive(noise, 150);
  EXPECT_GT(noise.stddev(), 0.04);
}

// The drift of odometry beside the map is not the map's.
TEST(MapNoise, IsNotLearntFromAPathOutsideTheMap) {
  MapNoise noise;
  NoisyMap map(0.003, 3e-4);
  map.drive(noise, 100);
  const double before = noise.stddev();
  map.drive(noise, 500, false);
  Pose drift;
  drift.translation.y() = 1.0;
  map.displace(drift);
  map.drive(noise, 50);
  EXPECT_LT(noise.stddev(), 1.1 * before);
}

TEST(MapNoise, IsNotLearntFromAJumpToAnotherPlace) {
  MapNoise noise;
  NoisyMap map(0.003, 3e-4);
  map.drive(noise, 100);
  const double before = noise.stddev();
  Pose jump;
  jump.translation.x() = 30.0;
  map.displace(jump);
  noise.interrupt();
  map.drive(noise, 50);
  EXPECT_LT(noise.stddev(), 1.1 * before);
}

}  // namespace
}  // namespace lidar_mapping::localization
