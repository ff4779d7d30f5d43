// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/pipeline/relative_odometry.hpp"

#include "near.hpp"

namespace lidar_mapping::pipeline {
namespace {

using test::near;

/// A step that stands at x (m), turned to the left by a quarter, with an error of 0.1 m and 0.01
/// rad.
OdometryStep step_to(Stamp stamp, double x) {
  return {stamp,
          {rotation_about_z(kPi / 2.0), Eigen::Vector3d(x, 0.0, 0.0)},
          diagonal_covariance(0.1, 0.01)};
}

OdometryStep new_begin(Stamp stamp, double x) {
  OdometryStep step = step_to(stamp, x);
  step.covariance.reset();
  return step;
}

TEST(RelativeOdometry, LeadsNowhereFromTheFirstScan) {
  RelativeOdometry motion;
  motion.add(step_to(1, 5.0));
  const auto input = motion.input_of({1, {}});
  EXPECT_FALSE(input.is_connected);
  EXPECT_EQ(input.scan.stamp, 1);
}

TEST(RelativeOdometry, GivesTheMotionInTheAxesOfTheVehicle) {
  RelativeOdometry motion;
  motion.add(step_to(1, 5.0));
  motion.input_of({1, {}});
  motion.add(step_to(2, 7.0));
  const auto input = motion.input_of({2, {}});
  EXPECT_TRUE(input.is_connected);
  EXPECT_TRUE(near(input.T_previous_base.translation, Eigen::Vector3d(0.0, -2.0, 0.0), 1e-12));
  EXPECT_TRUE(near(input.covariance, diagonal_covariance(0.1, 0.01), 1e-12))
      << "one step has its own covariance";
}

/// The second step of 3 m carries the error of the first in rotation to the side.
TEST(RelativeOdometry, AddsUpTheCovariancesOfSteps) {
  RelativeOdometry motion;
  motion.add(step_to(1, 0.0));
  motion.input_of({1, {}});
  motion.add(step_to(2, 1.0));
  motion.add(step_to(3, 4.0));
  const auto input = motion.input_of({3, {}});
  EXPECT_TRUE(near(input.T_previous_base.translation, Eigen::Vector3d(0.0, -4.0, 0.0), 1e-12));
  EXPECT_NEAR(input.covariance(0, 0), 2 * 0.1 * 0.1 + 3.0 * 3.0 * 0.01 * 0.01, 1e-12);
  EXPECT_NEAR(input.covariance(1, 1), 2 * 0.1 * 0.1, 1e-12);
}

TEST(RelativeOdometry, IsInterruptedForOneScan) {
  RelativeOdometry motion;
  motion.add(step_to(1, 0.0));
  motion.input_of({1, {}});
  motion.interrupt();
  motion.add(step_to(2, 1.0));
  EXPECT_FALSE(motion.input_of({2, {}}).is_connected);
  motion.add(new_begin(3, 50.0));
  motion.add(step_to(4, 51.0));
  EXPECT_FALSE(motion.input_of({4, {}}).is_connected) << "odometry began anew on the way";
  motion.add(step_to(5, 53.0));
  const auto input = motion.input_of({5, {}});
  EXPECT_TRUE(input.is_connected);
  EXPECT_TRUE(near(input.T_previous_base.translation, Eigen::Vector3d(0.0, -2.0, 0.0), 1e-12));
  EXPECT_TRUE(near(input.covariance, diagonal_covariance(0.1, 0.01), 1e-12))
      << "nothing of the steps before";
}

}  // namespace
}  // namespace lidar_mapping::pipeline
