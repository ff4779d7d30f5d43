// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/evaluation/lever_arm.hpp"

#include "near.hpp"

namespace lidar_mapping::evaluation {
namespace {

using test::near;

const Eigen::Vector3d kAntenna(1.2, -0.4, 1.9);  // m, in base_link

/// Poses of a vehicle that turns about all axes, or only drives straight on.
std::vector<Pose> drive(bool turns) {
  std::vector<Pose> poses;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.1 * i;
    Pose pose;
    if (turns) pose.rotation = exp_so3({0.2 * std::sin(3.0 * t), 0.3 * std::cos(2.0 * t), t});
    pose.translation = {5.0 * t, turns ? 2.0 * std::sin(t) : 0.0, 0.1 * t};
    poses.push_back(pose);
  }
  return poses;
}

/// The truth is that of the antenna, seen from another frame.
std::vector<PosePair> pairs_of(const std::vector<Pose>& estimates, const Pose& T_truth_estimate) {
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const Pose antenna = estimates[i] * Pose{Eigen::Quaterniond::Identity(), kAntenna};
    pairs.push_back({static_cast<Stamp>(i), T_truth_estimate * antenna, estimates[i]});
  }
  return pairs;
}

const Pose kOtherFrame{exp_so3({0.1, -0.2, 0.7}), {10.0, -20.0, 3.0}};

TEST(LeverArm, IsFoundInTheSameFrame) {
  const auto found = estimated_lever_arm(pairs_of(drive(true), {}), false);
  ASSERT_TRUE(found);
  EXPECT_TRUE(near(*found, kAntenna, 1e-9));
  const auto straight = estimated_lever_arm(pairs_of(drive(false), {}), false);
  ASSERT_TRUE(straight);
  EXPECT_TRUE(near(*straight, kAntenna, 1e-9)) << "no turn is needed";
}

TEST(LeverArm, IsFoundAlongWithTheMotionBetweenTheFrames) {
  const auto found = estimated_lever_arm(pairs_of(drive(true), kOtherFrame), true);
  ASSERT_TRUE(found);
  EXPECT_TRUE(near(*found, kAntenna, 1e-3));
}

/// Without turning, a lever arm is a shift of the frame.
TEST(LeverArm, IsZeroWhereTheVehicleDidNotTurn) {
  const auto found = estimated_lever_arm(pairs_of(drive(false), kOtherFrame), true);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, Eigen::Vector3d::Zero());
}

/// A car turns about the vertical alone, along which the lever arm stays unknown.
TEST(LeverArm, IsZeroAlongTheAxisOfAllTurns) {
  std::vector<Pose> poses = drive(true);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].rotation = exp_so3({0.0, 0.0, 0.1 * static_cast<double>(i)});
  }
  const auto found = estimated_lever_arm(pairs_of(poses, {}), true);
  ASSERT_TRUE(found);
  EXPECT_TRUE(near(*found, Eigen::Vector3d(kAntenna.x(), kAntenna.y(), 0.0), 1e-3));
}

TEST(LeverArm, NeedsThreePairs) {
  std::vector<PosePair> pairs = pairs_of(drive(true), {});
  pairs.resize(2);
  EXPECT_FALSE(estimated_lever_arm(pairs, true));
  EXPECT_FALSE(estimated_lever_arm({}, false));
}

TEST(LeverArm, MovesEstimatesOnTheVehicle) {
  const Pose T_estimate_truth{exp_so3({0.0, 0.0, 0.5}), kAntenna};
  const std::vector<PosePair> pairs = pairs_of(drive(true), {});
  const auto moved = moved_on_vehicle(pairs, T_estimate_truth);
  ASSERT_EQ(moved.size(), pairs.size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_TRUE(near(moved[i].estimate, pairs[i].estimate * T_estimate_truth, 1e-12));
    EXPECT_TRUE(near(moved[i].truth, pairs[i].truth, 1e-15));
  }
}

TEST(Turn, IsThatBetweenTheAxesOnTheVehicle) {
  const Eigen::Quaterniond turn = exp_so3({0.1, 0.2, -2.5});
  std::vector<PosePair> pairs = pairs_of(drive(true), {});
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].truth.rotation = pairs[i].estimate.rotation * turn;
    if (i % 2 == 0) pairs[i].truth.rotation.coeffs() *= -1.0;  // the same rotation
  }
  EXPECT_NEAR(rotation_angle(estimated_turn(pairs).conjugate() * turn), 0.0, 1e-7);
}

TEST(Turn, IsTheMeanOfTurnsThatDiffer) {
  std::vector<PosePair> pairs(2);
  pairs[0].truth.rotation = exp_so3({0.0, 0.0, 0.3});
  pairs[1].truth.rotation = exp_so3({0.0, 0.0, 0.1});
  EXPECT_NEAR(yaw_of(estimated_turn(pairs)), 0.2, 1e-9);
  EXPECT_THROW(estimated_turn({}), InputError);
}

}  // namespace
}  // namespace lidar_mapping::evaluation
