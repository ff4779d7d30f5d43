// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/pose_claim.hpp"

#include "near.hpp"

namespace lidar_mapping::pipeline {
namespace {

using test::near;

const Pose& claimed() {
  static const Pose T_map_base{exp_so3({0.0, 0.0, 0.5 * M_PI}), {10.0, 20.0, 0.0}};
  return T_map_base;
}

/// A scan so many metres ahead of the one before.
localization::LocalizerInput scan_after(double metres) {
  localization::LocalizerInput input;
  input.is_connected = true;
  input.T_previous_base.translation = {metres, 0.0, 0.0};
  return input;
}

TEST(PoseClaim, IsThatOfTheNextScan) {
  PoseClaim claim;
  claim.set(claimed());
  EXPECT_TRUE(claim.carry_to(scan_after(5.0)));
  const auto pose = claim.take();
  ASSERT_TRUE(pose.has_value());
  EXPECT_TRUE(near(*pose, claimed(), 1e-9));
  EXPECT_FALSE(claim.take().has_value());
}

/// There was no map, and the claim waited for it as it was while the vehicle drove on.
TEST(PoseClaim, IsCarriedAlongByOdometry) {
  PoseClaim claim;
  EXPECT_TRUE(claim.carry_to(scan_after(1.0)));  // nothing is claimed yet
  claim.set(claimed());
  for (const double metres : {5.0, 2.0, 4.0}) EXPECT_TRUE(claim.carry_to(scan_after(metres)));
  const auto pose = claim.take();
  ASSERT_TRUE(pose.has_value());
  EXPECT_TRUE(near(*pose, {claimed().rotation, {10.0, 26.0, 0.0}}, 1e-9));
}

TEST(PoseClaim, IsDroppedWhereOdometryIsInterrupted) {
  PoseClaim claim;
  claim.set(claimed());
  localization::LocalizerInput anew;
  anew.is_connected = false;
  EXPECT_TRUE(claim.carry_to(anew)) << "it is of this scan";
  EXPECT_FALSE(claim.carry_to(anew));
  EXPECT_TRUE(claim.carry_to(anew)) << "that is said once";
  EXPECT_FALSE(claim.take().has_value());
}

}  // namespace
}  // namespace lidar_mapping::pipeline
