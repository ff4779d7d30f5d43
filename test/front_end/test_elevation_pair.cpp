// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include "local_map/elevation_pair.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Which surfaces there are around the sensor.
struct Surroundings {
  bool walls = true;   ///< on all sides
  bool ground = true;  ///< level, 1.8 m below the sensor
};

/// What a sensor at this place (heading along x, m and rad) sees of a yard 40 m by 30 m, if it
/// reports all elevations too low by `error` (rad).
SampledPoints scan_from(const Pose& T_yard_sensor, unsigned seed, double error,
                        const Surroundings& surroundings = {}) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  SampledPoints points;
  for (int i = 0; i < 20'000; ++i) {
    Eigen::Vector3d p;
    const double along = unit(engine), other = unit(engine);
    if (i % 2 == 0) {
      if (!surroundings.ground) continue;
      p = {20.0 * along, 15.0 * other, -1.8};
    } else {
      if (!surroundings.walls) continue;
      const double side = i % 4 == 1 ? 1.0 : -1.0;
      const double up = 1.2 + 3.0 * other;
      p = i % 8 < 4 ? Eigen::Vector3d(20.0 * side, 15.0 * along, up)
                    : Eigen::Vector3d(20.0 * along, 15.0 * side, up);
    }
    p += Eigen::Vector3d(noise(engine), noise(engine), noise(engine));
    points.push_back((T_yard_sensor.inverse() * p).cast<float>(), 0.0F);
  }
  rotate_upwards(points, -error);
  return points;
}

Pose at(double x, double y, double yaw) { return {exp_so3({0.0, 0.0, yaw}), {x, y, 0.0}}; }

registration::GaussianVoxelMap map_of(const SampledPoints& points) {
  registration::GaussianVoxelMap map(1.0, 1 << 14);
  map.insert(points.x.data(), points.y.data(), points.z.data(), points.size());
  return map;
}

/// The estimate of two scans from different places, from a relative pose that is a little wrong.
std::optional<ElevationEstimate> estimate(double error, const Surroundings& surroundings = {}) {
  const Pose a = at(-6.0, 1.0, 0.0), b = at(5.0, -2.0, 0.3);
  auto map = map_of(scan_from(a, 1, error, surroundings));
  return estimate_elevation(scan_from(b, 2, error, surroundings), map,
                            a.inverse() * b * at(0.02, -0.02, 0.002));
}

// 0.0035 rad are the 0.2 degrees of KITTI's sensor.
TEST(ElevationPair, FindsTheAngle) {
  for (const double error : {0.0, 0.0035, -0.0035, 0.006, -0.006}) {
    const auto found = estimate(error);
    ASSERT_TRUE(found.has_value()) << error;
    EXPECT_NEAR(found->angle, error, 0.0006) << error;
    EXPECT_GT(found->sigma, 0.0);
    EXPECT_LT(found->sigma, 0.0006);
  }
}

TEST(ElevationPair, RejectsAnAngleThatNoSensorHas) { EXPECT_FALSE(estimate(0.05).has_value()); }

// Level ground alone leaves the pose open, and walls alone the height.
TEST(ElevationPair, SaysNothingWhereThePoseIsNotDetermined) {
  EXPECT_FALSE(estimate(0.003, {false, true}).has_value());
  EXPECT_FALSE(estimate(0.003, {true, false}).has_value());
  EXPECT_FALSE(estimate(0.003, {false, false}).has_value());
}

TEST(ElevationPair, SaysNothingAboutScansThatDoNotOverlap) {
  const SampledPoints scan = scan_from(at(0.0, 0.0, 0.0), 1, 0.003);
  registration::GaussianVoxelMap empty(1.0, 1 << 10);
  EXPECT_FALSE(estimate_elevation(scan, empty, Pose()).has_value());
  auto map = map_of(scan);
  EXPECT_FALSE(estimate_elevation(scan, map, at(500.0, 0.0, 0.0)).has_value());
  EXPECT_FALSE(estimate_elevation(SampledPoints(), map, Pose()).has_value());
}

// From one place the ground looks the same twice, however wrong its elevations are.
TEST(ElevationPair, KnowsLessFromPlacesThatAreNearer) {
  const auto sigma_over = [](double distance) {
    auto map = map_of(scan_from(at(0.0, 0.0, 0.0), 1, 0.0));
    const auto found =
        estimate_elevation(scan_from(at(distance, 0.0, 0.0), 2, 0.0), map, at(distance, 0.0, 0.0));
    return found ? found->sigma : 1.0;
  };
  EXPECT_GT(sigma_over(1.0), 2.0 * sigma_over(8.0));
}

}  // namespace
}  // namespace lidar_mapping::front_end
