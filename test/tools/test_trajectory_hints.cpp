// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "comparison/trajectory_hints.hpp"
#include "holds.hpp"

namespace lidar_mapping::tools {
namespace {

using evaluation::PosePair;
using test::holds;
using Pairs = std::vector<PosePair>;

/// A drive whose estimate wavers by a centimetre.
Pairs drive() {
  Pairs pairs;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.1 * i;
    Pose truth{exp_so3({0.2 * std::sin(2.0 * t), 0.1 * std::cos(t), 0.4 * t}),
               {5.0 * t, 10.0 * std::sin(0.2 * t), 0.0}};
    Pose estimate = truth;
    estimate.translation.x() += 0.01 * std::sin(7.0 * t);
    pairs.push_back({static_cast<Stamp>(i), truth, estimate});
  }
  return pairs;
}

/// The drive with its truth in another frame, and of another point and with other axes on the
/// vehicle.
Pairs with_truth(const Pose& frame, const Pose& on_vehicle) {
  Pairs pairs = drive();
  for (PosePair& pair : pairs) pair.truth = frame * pair.truth * on_vehicle;
  return pairs;
}

const Pose kFrame{exp_so3({0.0, 0.0, 1.0}), {100.0, 0.0, 5.0}};
const Pose kAntenna{Eigen::Quaterniond::Identity(), {1.5, 0.25, 2.0}};

TEST(TrajectoryHints, AreNotGivenForAnOrdinaryError) {
  EXPECT_TRUE(trajectory_hints(drive(), {}).empty());
}

TEST(TrajectoryHints, ProposeAnAlignment) {
  const auto hints = trajectory_hints(with_truth(kFrame, {}), {});
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_TRUE(holds(hints[0], "with --align: the trajectories lie in different frames"));
}

TEST(TrajectoryHints, ProposeALeverArm) {
  const auto hints = trajectory_hints(with_truth({}, kAntenna), {});
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_TRUE(holds(hints[0], "with --lever-arm 1.50 0.25 2.00: "));
}

TEST(TrajectoryHints, ProposeBoth) {
  const auto hints = trajectory_hints(with_truth(kFrame, kAntenna), {});
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_TRUE(holds(hints[0], "with --align --lever-arm 1.50 0.25 2.00: "));
}

TEST(TrajectoryHints, ProposeOtherAxes) {
  const Pose turned{exp_so3({0.0, 0.0, 1.5707963267948966}), {0.0, 0.0, 0.0}};
  const auto hints = trajectory_hints(with_truth({}, turned), {});
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_TRUE(holds(hints[0], "with --lever-rotation 0.0 0.0 90.0: "));
}

TEST(TrajectoryHints, DoNotRepeatWhatWasApplied) {
  const Pairs shifted = with_truth(kFrame, {});
  EXPECT_TRUE(trajectory_hints(shifted, {true, true, true}).empty());
  const Pairs of_antenna = with_truth({}, kAntenna);
  EXPECT_TRUE(trajectory_hints(of_antenna, {true, true, true}).empty());
  const auto hints = trajectory_hints(of_antenna, {true, false, true});
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_TRUE(holds(hints[0], "--align --lever-arm"));
}

/// A straight tunnel leaves the rotation about it free, so an alignment proves nothing of axes.
TEST(TrajectoryHints, DoNotProposeTheAxesOfAFreeRotation) {
  Pairs pairs;
  for (int i = 0; i < 200; ++i) {
    const Pose truth{Eigen::Quaterniond::Identity(), {1.0 * i, 0.0, 0.0}};
    Pose estimate = truth;
    estimate.translation +=
        Eigen::Vector3d(0.5, 0.02 * std::sin(0.2 * i), 0.02 * std::cos(0.2 * i));
    pairs.push_back({static_cast<Stamp>(i), truth, estimate});
  }
  for (const std::string& hint : trajectory_hints(pairs, {})) {
    EXPECT_FALSE(holds(hint, "--lever-rotation")) << hint;
  }
}

/// Orientations agree before the alignment that the positions call for, and not after it.
TEST(TrajectoryHints, DoNotProposeAxesForTheErrorOfAnAlignment) {
  Pairs pairs = drive();
  const Eigen::Quaterniond roll = exp_so3({0.5, 0.0, 0.0});
  for (PosePair& pair : pairs) {
    pair.truth.rotation = pair.estimate.rotation = Eigen::Quaterniond::Identity();
    pair.estimate.translation = roll * pair.estimate.translation;
  }
  const auto hints = trajectory_hints(pairs, {});
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_TRUE(holds(hints[0], "with --align"));
}

/// Two centimetres are no hint, however much of the error they are.
TEST(TrajectoryHints, LeaveSmallGainsOut) {
  const Pose near_by{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.015}};
  EXPECT_TRUE(trajectory_hints(with_truth(near_by, {}), {}).empty());
  const Pose hardly_turned{exp_so3({0.0, 0.0, 0.005}), {0.0, 0.0, 0.0}};  // 0.3 degrees
  EXPECT_TRUE(trajectory_hints(with_truth({}, hardly_turned), {}).empty());
}

TEST(TrajectoryHints, NeedThreePoses) {
  Pairs pairs = with_truth(kFrame, kAntenna);
  pairs.resize(2);
  EXPECT_TRUE(trajectory_hints(pairs, {}).empty());
}

}  // namespace
}  // namespace lidar_mapping::tools
