// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "near.hpp"
#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {
namespace {

using test::near;

constexpr double kSlope = 0.1;

Terrain hills(std::uint64_t seed = 1) { return {Random(seed), 8, 30.0, 90.0, kSlope}; }

TEST(Terrain, IsFlatWithoutWaves) {
  const Terrain flat;
  EXPECT_EQ(flat.height({12.0, -7.0}), 0.0);
  EXPECT_EQ(flat.gradient({12.0, -7.0}).norm(), 0.0);
  EXPECT_TRUE(near(flat.on_ground({12.0, -7.0}, 1.5), Eigen::Vector3d(12.0, -7.0, 1.5), 1e-12));
}

TEST(Terrain, GradientIsTheDerivativeOfTheHeight) {
  const Terrain terrain = hills();
  constexpr double kStep = 1e-4;  // m
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d at(7.3 * i, -4.1 * i);
    const Eigen::Vector2d dx(kStep, 0.0), dy(0.0, kStep);
    const Eigen::Vector2d numeric((terrain.height(at + dx) - terrain.height(at - dx)),
                                  (terrain.height(at + dy) - terrain.height(at - dy)));
    EXPECT_TRUE(near(terrain.gradient(at), numeric / (2.0 * kStep), 1e-7));
  }
}

TEST(Terrain, PutsPointsOnTheGround) {
  const Terrain terrain = hills();
  const Eigen::Vector2d at(31.0, 17.0);
  EXPECT_TRUE(near(terrain.on_ground(at), Eigen::Vector3d(31.0, 17.0, terrain.height(at)), 1e-12));
  EXPECT_NEAR(terrain.on_ground(at, 2.0).z() - terrain.height(at), 2.0, 1e-12);
}

// Waves of random directions and phases: the mean square of the slopes is half of that of one wave.
TEST(Terrain, HasAboutTheGivenSlope) {
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Terrain terrain = hills(seed);
    for (int i = 0; i < 60; ++i) {
      for (int k = 0; k < 60; ++k, ++count) {
        squares += terrain.gradient({11.0 * i, 13.0 * k}).squaredNorm();
      }
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), kSlope / std::sqrt(2.0), 0.2 * kSlope);
}

TEST(Terrain, DependsOnItsSeed) {
  const Eigen::Vector2d at(31.0, 17.0);
  EXPECT_EQ(hills(3).height(at), hills(3).height(at));
  EXPECT_NE(hills(3).height(at), hills(4).height(at));
}

}  // namespace
}  // namespace lidar_mapping::simulation
