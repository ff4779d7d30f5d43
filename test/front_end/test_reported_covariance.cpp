// SPDX-License-Identifier: BSD-3-Clause
// The covariances that are reported of a match, and what the tracker's state takes over from it.

#include <cmath>

#include <gtest/gtest.h>

#include "judgement/reported_covariance.hpp"
#include "motion/motion_filter.hpp"
#include "near.hpp"
#include "tracking/tracker_state.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::NdtMatch;
using test::near;

MotionState driving_at(double x, double speed) {
  MotionState state;
  state.T_map_sensor.translation.x() = x;
  state.twist[0] = speed;
  return state;
}

/// The points have an information of 100 in each direction, the prior of 3.
NdtMatch match_with(double residual_variance, double overlap = 0.9) {
  NdtMatch match;
  match.state = driving_at(1.0, 10.0);
  match.points_information = 100.0 * Matrix12d::Identity();
  match.information = 103.0 * Matrix12d::Identity();
  match.residual_variance = residual_variance;
  match.overlap = overlap;
  return match;
}

TEST(ReportedCovariance, WeighsPointsByWhatTheirResidualsShow) {
  for (const double variance : {0.25, 1.0, 4.0}) {
    const double weight = 55.0 / std::sqrt(variance);
    const Matrix12d expected = Matrix12d::Identity() / (3.0 + 100.0 * weight);
    EXPECT_TRUE(near(reported_covariance(match_with(variance)), expected, 1e-9)) << variance;
  }
}

// A map of one scan fits that scan too well.
TEST(ReportedCovariance, DoesNotBelieveInResidualsThatAreTooSmall) {
  EXPECT_EQ(credible_residual_variance(match_with(0.01)), 0.05);
  EXPECT_EQ(credible_residual_variance(match_with(0.06)), 0.06);
  EXPECT_TRUE(
      near(reported_covariance(match_with(0.0)), reported_covariance(match_with(0.05)), 1e-15));
}

TEST(ReportedCovariance, KeepsWhatOnlyThePriorKnows) {
  NdtMatch match = match_with(1.0);
  match.points_information(0, 0) = 0.0;
  match.information(0, 0) = 3.0;
  EXPECT_NEAR(reported_covariance(match)(0, 0), 1.0 / 3.0, 1e-9);
}

TEST(InitialDriftVarianceFactor, GrowsAsFewerPointsFindAPlane) {
  const auto factor = [](double overlap) {
    return initial_drift_variance_factor(match_with(1.0, overlap));
  };
  EXPECT_NEAR(factor(0.75), 2.5, 1e-9);
  EXPECT_NEAR(factor(1.0), 2.5, 1e-9) << "enough is enough";
  EXPECT_NEAR(factor(0.6), 2.5 * std::pow(1.25, 8.0), 1e-9);
  EXPECT_NEAR(factor(0.45), 2.5 * std::pow(5.0 / 3.0, 8.0), 1e-9);
  EXPECT_NEAR(factor(0.1), factor(0.45), 1e-9) << "it is bounded";
}

TEST(DriftVarianceFactor, IsOneOnceTheMapHasMoreThanTwelveScans) {
  TrackerState state{FrontEndConfig{}};
  state.coverage.inserted_scans = 12;
  EXPECT_NEAR(drift_variance_factor(state, match_with(1.0)), 2.5, 1e-9);
  state.coverage.inserted_scans = 13;
  EXPECT_EQ(drift_variance_factor(state, match_with(1.0)), 1.0);
}

// The match is wrong with one in four; then the prediction is right, which lies 2 m and 3 m/s away.
TEST(DoubtCovariance, IsThatOfTheMixtureOfMatchAndPrediction) {
  const registration::MotionBelief prediction = {driving_at(3.0, 7.0), 4.0 * Matrix12d::Identity()};
  const Matrix12d covariance = doubt_covariance(driving_at(1.0, 10.0), prediction, 0.75);
  EXPECT_NEAR(covariance(0, 0), 0.25 * (2.0 * 2.0 + 0.25), 1e-9);
  EXPECT_NEAR(covariance(6, 6), 0.25 * (3.0 * 3.0 + 0.25), 1e-9);
  EXPECT_NEAR(covariance(0, 6), 0.25 * (2.0 * -3.0), 1e-9);
  EXPECT_NEAR(covariance(6, 0), covariance(0, 6), 1e-12);
  EXPECT_NEAR(covariance(1, 1), 0.25 * 0.25, 1e-9);
  EXPECT_TRUE(test::near(doubt_covariance(driving_at(1.0, 10.0), prediction, 1.0),
                         Matrix12d::Zero(), 1e-12));
}

TEST(GapBetween, IsZeroForASteadyMotion) {
  const PreviousMatch previous{driving_at(0.0, 10.0), 0.1};
  EXPECT_TRUE(test::near(gap_between(previous, driving_at(1.0, 10.0)), Vector6d::Zero(), 1e-12));
  // With 2 m/s^2.
  EXPECT_TRUE(test::near(gap_between(previous, driving_at(1.01, 10.2)), Vector6d::Zero(), 1e-12));
}

TEST(GapBetween, ShowsAJumpOfThePose) {
  const Vector6d gap = gap_between({driving_at(0.0, 10.0), 0.1}, driving_at(1.3, 10.0));
  EXPECT_NEAR(std::abs(gap[0]), 0.3, 1e-12);
  EXPECT_NEAR(gap.tail<5>().norm(), 0.0, 1e-12);
}

TEST(TrackerState, TakesOverAMatch) {
  TrackerState state{FrontEndConfig{}};
  start_motion(Pose{}, 0.0, state);
  state.filter.predict(0.1);
  state.coverage.inserted_scans = 5;
  state.lost_time = 0.7;
  SweepMatcher::Found found;
  found.match = match_with(1.0, 0.6);
  correct_motion(found, 0.1, state);
  EXPECT_TRUE(near(state.covariance, reported_covariance(found.match), 1e-12));
  EXPECT_TRUE(near(state.filter.state().T_map_sensor, found.match.state.T_map_sensor, 1e-12));
  EXPECT_TRUE(near(state.last_matched_pose, found.match.state.T_map_sensor, 1e-12));
  EXPECT_NEAR(state.drift_variance_factor, 2.5 * std::pow(1.25, 8.0), 1e-9);
  EXPECT_EQ(state.lost_time, 0.0);
}

TEST(TrackerState, KeepsItsMotionWithoutItsMap) {
  TrackerState state{FrontEndConfig{}};
  state.filter.restart(driving_at(5.0, 10.0), Matrix12d::Identity());
  SampledPoints points;
  points.push_back({1.0F, 2.0F, 3.0F}, 0.0F);
  state.map.insert(points, driving_at(5.0, 0.0));
  state.coverage = {20, false};
  state.motion_known = true;
  state.lost_time = 0.7;
  ASSERT_FALSE(state.map.empty());
  state.discard_map();
  EXPECT_TRUE(state.map.empty());
  EXPECT_EQ(state.coverage.inserted_scans, 0);
  EXPECT_TRUE(state.coverage.is_single_place);
  EXPECT_FALSE(state.motion_known);
  EXPECT_EQ(state.lost_time, 0.0);
  EXPECT_EQ(state.filter.state().T_map_sensor.translation.x(), 5.0);
  EXPECT_EQ(state.filter.state().twist[0], 10.0);
}

}  // namespace
}  // namespace lidar_mapping::front_end
