// SPDX-License-Identifier: BSD-3-Clause
// What doubtful steps add to the covariance of a motion.

#include <gtest/gtest.h>

#include "evaluated_drive.hpp"
#include "judgement/covariance_inflation.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

FrontEndStatus status_of(TrackingState state, double error = 0.0, double error_angle = 0.0) {
  FrontEndStatus status;
  status.state = state;
  status.expected_error = error;
  status.expected_error_angle = error_angle;
  return status;
}

Pose ahead(double metres) {
  Pose pose;
  pose.translation.x() = metres;
  return pose;
}

TEST(CovarianceInflation, IsZeroWithoutDoubtfulSteps) {
  CovarianceInflation inflation;
  for (const auto state : {TrackingState::kTracking, TrackingState::kDegenerate}) {
    inflation.add_step(ahead(1.0), status_of(state, 0.5, 0.05));
  }
  EXPECT_TRUE(inflation.covariance().isZero(0.0));
  KeyFrame key_frame;
  inflation.apply_to(key_frame);
  EXPECT_FALSE(key_frame.doubtful);
  EXPECT_EQ(key_frame.motion_covariance, Covariance6::Identity());
}

TEST(CovarianceInflation, ContainsTheExpectedErrorInEveryDirection) {
  CovarianceInflation inflation;
  inflation.add_step(ahead(1.0), status_of(TrackingState::kDoubtful, 0.3, 0.02));
  EXPECT_TRUE(test::near(inflation.covariance(), diagonal_covariance(0.3, 0.02), 1e-15));
}

TEST(CovarianceInflation, AddsStepsAsIndependent) {
  CovarianceInflation inflation;
  inflation.add_step({}, status_of(TrackingState::kDoubtful, 0.3, 0.03));
  inflation.add_step({}, status_of(TrackingState::kDoubtful, 0.4, 0.04));
  EXPECT_TRUE(test::near(inflation.covariance(), diagonal_covariance(0.5, 0.05), 1e-15));
}

// 10 m further on a turn of 0.02 rad is a shift of 0.2 m aside and up, and none along.
TEST(CovarianceInflation, PropagatesARotationErrorToLaterSteps) {
  CovarianceInflation inflation;
  inflation.add_step({}, status_of(TrackingState::kDoubtful, 0.1, 0.02));
  inflation.add_step(ahead(10.0), status_of(TrackingState::kTracking, 0.5, 0.5));
  const Covariance6& covariance = inflation.covariance();
  EXPECT_NEAR(covariance(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 0.01 + 0.04, 1e-12);
  EXPECT_NEAR(covariance(2, 2), 0.01 + 0.04, 1e-12);
  EXPECT_NEAR(covariance(5, 5), 0.0004, 1e-12);
  EXPECT_NEAR(covariance(1, 5), 0.004, 1e-12) << "a turn to the left leads to the left";
}

TEST(CovarianceInflation, IsAddedToTheCovarianceOfAKeyFrame) {
  CovarianceInflation inflation;
  inflation.add_step({}, status_of(TrackingState::kDoubtful, 0.3, 0.02));
  KeyFrame key_frame;
  key_frame.motion_covariance = diagonal_covariance(0.4, 0.0);
  inflation.apply_to(key_frame);
  EXPECT_TRUE(key_frame.doubtful);
  EXPECT_TRUE(test::near(key_frame.motion_covariance, diagonal_covariance(0.5, 0.02), 1e-15));
}

struct KeyFramesAndSteps {
  std::vector<KeyFrame> key_frames;
  int doubtful_steps = 0;
};

/// Every n-th scan of a drive.
KeyFramesAndSteps key_frames_of(const simulation::Drive& drive, std::size_t every) {
  EvaluatedDrive ride(drive);
  KeyFramesAndSteps found;
  for (std::size_t i = 0; i < drive.scan_count(); i += every) {
    const FrontEndResult& result = ride.process(i);
    if (result.key_frame) found.key_frames.push_back(*result.key_frame);
    if (result.status.state != TrackingState::kDoubtful) continue;
    ++found.doubtful_steps;
    const double e = result.status.expected_error;
    EXPECT_GT((result.covariance.topLeftCorner<3, 3>().trace()), 3.0 * e * e);
  }
  return found;
}

// Hand-held, a scan every 0.8 s.
TEST(CovarianceInflation, IsInTheKeyFramesOfAWalkWithFewScans) {
  const KeyFramesAndSteps found = key_frames_of(make_drive("walk", 20.0, 52), 8);
  EXPECT_GT(found.doubtful_steps, 0);
  const auto doubtful = [](const KeyFrame& k) { return k.doubtful; };
  const auto at = std::find_if(found.key_frames.begin(), found.key_frames.end(), doubtful);
  ASSERT_NE(at, found.key_frames.end());
  EXPECT_GT((at->motion_covariance.topLeftCorner<3, 3>().trace()), 1e-3);
}

TEST(CovarianceInflation, IsNotInTheKeyFramesOfACleanWalk) {
  for (const KeyFrame& key_frame : key_frames_of(make_drive("walk", 10.0, 201), 1).key_frames) {
    EXPECT_FALSE(key_frame.doubtful);
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
