// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/simulation/random.hpp"

#include "normalized_errors.hpp"

namespace lidar_mapping::campaign {
namespace {

using front_end::FrontEndResult;
using front_end::TrackingState;

constexpr double kSigmaM = 0.01;     // m
constexpr double kSigmaRad = 0.002;  // rad

Pose at(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

/// A motion with an error drawn from the covariance of kSigmaM and kSigmaRad.
Pose disturbed(const Pose& motion, simulation::Random& random) {
  Vector6d error;
  for (int i = 0; i < 6; ++i) error[i] = (i < 3 ? kSigmaM : kSigmaRad) * random.normal();
  return perturbed(motion, error);
}

FrontEndResult result_at(const Pose& claim, TrackingState state = TrackingState::kTracking) {
  FrontEndResult result;
  result.T_odom_base = claim;
  result.covariance = diagonal_covariance(kSigmaM, kSigmaRad);
  result.status.state = state;
  return result;
}

FrontEndResult key_frame_at(const Pose& claim, bool doubtful = false) {
  FrontEndResult result = result_at(claim);
  result.key_frame.emplace();
  result.key_frame->motion_covariance = diagonal_covariance(2.0 * kSigmaM, 2.0 * kSigmaRad);
  result.key_frame->doubtful = doubtful;
  return result;
}

TEST(NormalizedErrors, AreOneForHonestCovariancesAndFourForHalvedDeviations) {
  simulation::Random random(7);
  NormalizedErrors honest, bold;
  for (int i = 0; i < 3000; ++i) {
    const Pose truth{exp_so3({0.1, -0.2, 0.3}), {1.0, 2.0, 3.0}};
    const Pose claim = disturbed(truth, random);
    honest.add(truth, claim, diagonal_covariance(kSigmaM, kSigmaRad));
    bold.add(truth, claim, diagonal_covariance(0.5 * kSigmaM, 0.5 * kSigmaRad));
  }
  EXPECT_EQ(honest.count(), 3000U);
  EXPECT_NEAR(*honest.mean(), 1.0, 0.05);
  EXPECT_NEAR(*bold.mean(), 4.0, 0.2);
  EXPECT_FALSE(NormalizedErrors().mean());
}

TEST(MotionErrors, TakesStepsThatAreTrackedWithinASegment) {
  MotionErrors errors;
  errors.add(result_at(at(0.0)), at(0.0));
  EXPECT_EQ(errors.steps().count(), 0U) << "the first scan ends no step";
  errors.add(result_at(at(1.0 + kSigmaM)), at(1.0));
  ASSERT_EQ(errors.steps().count(), 1U);
  EXPECT_NEAR(*errors.steps().mean(), 1.0 / 6.0, 1e-9);
  errors.add(result_at(at(9.0), TrackingState::kLost), at(2.0));
  EXPECT_EQ(errors.steps().count(), 1U);
  FrontEndResult other = result_at(at(0.0));
  other.segment = 1;
  errors.add(other, at(3.0));
  EXPECT_EQ(errors.steps().count(), 1U) << "nothing leads from one segment to the next";
}

TEST(MotionErrors, ComparesKeyFramesWithTheKeyFrameBefore) {
  MotionErrors errors;
  errors.add(key_frame_at(at(0.0)), at(0.0));
  errors.add(result_at(at(1.0)), at(1.0));
  errors.add(key_frame_at(at(2.0 + 2.0 * kSigmaM)), at(2.0));
  ASSERT_EQ(errors.edges().count(), 1U);
  EXPECT_NEAR(*errors.edges().mean(), 1.0 / 6.0, 1e-9);
  errors.add(key_frame_at(at(5.0), true), at(3.0));
  FrontEndResult open = key_frame_at(at(6.0));
  open.key_frame->degenerate_directions.push_back(Eigen::Vector3d::UnitX());
  errors.add(open, at(4.0));
  EXPECT_EQ(errors.edges().count(), 1U) << "a doubtful edge or an open direction claims less";
}

}  // namespace
}  // namespace lidar_mapping::campaign
