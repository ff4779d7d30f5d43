// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

constexpr Stamp kBegin = 1'000'000'000'000;

/// A motion with rotations about all axes at once.
SmoothTrajectory trajectory_about_all_axes() {
  std::vector<Vector6d> control;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.05 * i;
    Vector6d c;
    c << 5.0 * std::sin(t), 3.0 * t, std::cos(2.0 * t), 1.5 * t, 0.8 * std::sin(1.3 * t),
        0.7 * std::cos(1.7 * t);
    control.push_back(c);
  }
  return {kBegin, 0.05, control};
}

class SmoothTrajectoryProperty : public testing::TestWithParam<int> {
 protected:
  SmoothTrajectory trajectory = trajectory_about_all_axes();
  Random random{99, static_cast<std::uint64_t>(GetParam())};
  Stamp stamp = kBegin + from_seconds(random.uniform(0.1, 9.5));
  Stamp h = 1'000'000;
  Pose before = trajectory.pose(stamp - h);
  Pose after = trajectory.pose(stamp + h);
};

TEST_P(SmoothTrajectoryProperty, VelocityIsTheDerivativeOfPosition) {
  const Eigen::Vector3d expected = (after.translation - before.translation) / to_seconds(2 * h);
  EXPECT_TRUE(test::near(trajectory.state(stamp).velocity_map, expected, 1e-4));
}

TEST_P(SmoothTrajectoryProperty, AngularVelocityIsTheDerivativeOfRotationInTheAxesOfTheBody) {
  const Eigen::Vector3d expected =
      log_so3(before.rotation.conjugate() * after.rotation) / to_seconds(2 * h);
  EXPECT_TRUE(test::near(trajectory.state(stamp).angular_velocity_base, expected, 1e-4));
}

TEST_P(SmoothTrajectoryProperty, AccelerationsAreTheDerivativesOfVelocities) {
  const MotionState a = trajectory.state(stamp - h), b = trajectory.state(stamp + h);
  const MotionState state = trajectory.state(stamp);
  const double dt = to_seconds(2 * h);
  EXPECT_TRUE(test::near(state.acceleration_map, (b.velocity_map - a.velocity_map) / dt, 1e-3));
  EXPECT_TRUE(test::near(state.angular_acceleration_base,
                         (b.angular_velocity_base - a.angular_velocity_base) / dt, 1e-3));
}

TEST_P(SmoothTrajectoryProperty, MotionOfFixedFrameAgreesWithItsPoses) {
  const Pose T_base_frame{exp_so3({0.4, -0.3, 1.2}), {0.7, -0.4, 1.1}};
  const auto of_frame = [&](Stamp at) { return trajectory.state(at).of_frame(T_base_frame); };
  const MotionState a = of_frame(stamp - h), b = of_frame(stamp + h), state = of_frame(stamp);
  const double dt = to_seconds(2 * h);
  const Eigen::Vector3d velocity = (b.T_map_base.translation - a.T_map_base.translation) / dt;
  const Eigen::Vector3d rate =
      log_so3(a.T_map_base.rotation.conjugate() * b.T_map_base.rotation) / dt;
  EXPECT_TRUE(test::near(state.velocity_map, velocity, 1e-4));
  EXPECT_TRUE(test::near(state.angular_velocity_base, rate, 1e-4));
  EXPECT_TRUE(test::near(state.acceleration_map, (b.velocity_map - a.velocity_map) / dt, 1e-3));
}

INSTANTIATE_TEST_SUITE_P(RandomInstants, SmoothTrajectoryProperty, testing::Range(0, 20));

TEST(SmoothTrajectory, ThrowsOutsideItsTime) {
  const SmoothTrajectory trajectory = trajectory_about_all_axes();
  EXPECT_NO_THROW(trajectory.pose(trajectory.begin()));
  EXPECT_NO_THROW(trajectory.pose(trajectory.end()));
  EXPECT_THROW(trajectory.pose(trajectory.begin() - 1), InputError);
  EXPECT_THROW(trajectory.pose(trajectory.end() + 1), InputError);
}

TEST(SmoothTrajectory, ConstantControlPointsGiveConstantPose) {
  Vector6d c;
  c << 1.0, 2.0, 3.0, 0.4, 0.1, -0.2;
  const SmoothTrajectory trajectory(kBegin, 0.1, std::vector<Vector6d>(20, c));
  EXPECT_TRUE(test::near(trajectory.pose(kBegin + 700'000'000).translation, c.head<3>(), 1e-12));
  EXPECT_NEAR(trajectory.length(trajectory.begin(), trajectory.end()), 0.0, 1e-12);
}

}  // namespace
}  // namespace lidar_mapping::simulation
