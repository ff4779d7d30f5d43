// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "near.hpp"

namespace lidar_mapping::evaluation {
namespace {

/// A straight drive along x with a pose per metre and per second.
Trajectory straight(int poses) {
  Trajectory trajectory;
  for (int i = 0; i < poses; ++i) {
    trajectory.poses.push_back(
        {from_seconds(i), {Eigen::Quaterniond::Identity(), {1.0 * i, 0.0, 0.0}}});
  }
  return trajectory;
}

Trajectory moved(Trajectory trajectory, const Pose& T) {
  for (StampedPose& entry : trajectory.poses) entry.pose = T * entry.pose;
  return trajectory;
}

/// A bent drive, so that an alignment is unique.
Trajectory bent() {
  Trajectory trajectory;
  for (int i = 0; i < 50; ++i) {
    const double angle = 0.05 * i;
    trajectory.poses.push_back(
        {from_seconds(0.1 * i),
         {exp_so3({0.0, 0.0, angle}),
          {20.0 * std::sin(angle), 20.0 - 20.0 * std::cos(angle), 0.1 * i}}});
  }
  return trajectory;
}

// Worked out by hand: errors of 0, 3 and 4 m.
TEST(Statistics, OfThreeValues) {
  const ErrorStatistics statistics = statistics_of({4.0, 0.0, 3.0});
  EXPECT_EQ(statistics.count, 3U);
  EXPECT_DOUBLE_EQ(statistics.rmse, std::sqrt(25.0 / 3.0));
  EXPECT_DOUBLE_EQ(statistics.mean, 7.0 / 3.0);
  EXPECT_DOUBLE_EQ(statistics.median, 3.0);
  EXPECT_DOUBLE_EQ(statistics.max, 4.0);
}

TEST(Statistics, OfNothingAreZero) {
  const ErrorStatistics statistics = statistics_of({});
  EXPECT_EQ(statistics.count, 0U);
  EXPECT_EQ(statistics.rmse, 0.0);
  EXPECT_EQ(statistics.max, 0.0);
}

TEST(AbsolutePoseError, OfAShiftedTrack) {
  const Pose shift{Eigen::Quaterniond::Identity(), {3.0, 4.0, 0.0}};
  const auto pairs = associate(straight(10), moved(straight(10), shift));
  EXPECT_DOUBLE_EQ(absolute_pose_error(pairs).translation_m.rmse, 5.0);
  EXPECT_DOUBLE_EQ(absolute_pose_error(pairs).rotation_deg.max, 0.0);
}

TEST(AbsolutePoseError, VanishesAfterAlignment) {
  const Pose T{exp_so3({0.1, -0.3, 2.0}), {100.0, -50.0, 7.0}};
  const auto pairs = associate(bent(), moved(bent(), T));
  const auto fitted = aligned(pairs, rigid_alignment(pairs));
  EXPECT_LT(absolute_pose_error(fitted).translation_m.max, 1e-9);
  EXPECT_LT(absolute_pose_error(fitted).rotation_deg.max, 1e-6);
}

/// A straight drive whose estimate is off by a few centimetres that spiral about the line.
std::vector<PosePair> spiralling_pairs() {
  Trajectory estimate = straight(100);
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    const double phase = 0.3 * static_cast<double>(i);
    estimate.poses[i].pose.translation +=
        Eigen::Vector3d(0.0, std::cos(phase), std::sin(phase)) * 0.03;
  }
  const Pose elsewhere{exp_so3({0.4, 0.0, 0.0}), {0.0, 5.0, 0.0}};
  return associate(straight(100), moved(estimate, elsewhere), 1.5);
}

// In a tunnel the truth would be turned by any angle about its line.
TEST(RigidAlignment, TakesTheRollAboutAStraightPathFromTheOrientations) {
  const auto pairs = spiralling_pairs();
  for (const Pose& T : {rigid_alignment(pairs), similarity_alignment(pairs).T_truth_estimate}) {
    const PoseErrors errors = absolute_pose_error(aligned(pairs, T));
    EXPECT_LT(errors.rotation_deg.max, 0.5);
    EXPECT_LT(errors.translation_m.max, 0.04);
  }
}

// What turns determines all of the motion: orientations that are wrong do not bend it.
TEST(RigidAlignment, IsThatOfThePositionsWhereTheseDetermineIt) {
  auto pairs = associate(bent(), bent());
  for (PosePair& pair : pairs) {
    pair.estimate.rotation = exp_so3({0.5, 0.0, 0.0});
    pair.estimate.translation.y() += 0.01;
  }
  EXPECT_LT(rotation_angle(rigid_alignment(pairs).rotation), 1e-6);
}

TEST(SimilarityAlignment, FindsTheScale) {
  Trajectory longer = bent();
  for (StampedPose& entry : longer.poses) entry.pose.translation *= 1.25;
  const SimilarityAlignment found = similarity_alignment(associate(bent(), longer));
  EXPECT_NEAR(found.scale, 0.8, 1e-9);
  EXPECT_TRUE(test::near(found.T_truth_estimate.translation, Eigen::Vector3d::Zero(), 1e-9));
}

TEST(SimilarityAlignment, NeedsTwoTrajectoriesThatMove) {
  Trajectory still = bent();
  for (StampedPose& entry : still.poses) entry.pose.translation = {30.1, -2.7, 0.3};
  EXPECT_THROW(similarity_alignment(associate(bent(), still)), InputError);
  EXPECT_THROW(similarity_alignment(associate(still, bent())), InputError);
}

// Every step is 1 % too long: 1 cm per metre, 10 cm per ten metres, 1 % of each segment.
TEST(RelativeErrors, OfAScaledTrack) {
  Trajectory longer = straight(301);
  for (StampedPose& entry : longer.poses) entry.pose.translation *= 1.01;
  const auto pairs = associate(straight(301), longer);
  EXPECT_NEAR(relative_pose_error(pairs, 0.0).translation_m.rmse, 0.01, 1e-9);
  EXPECT_NEAR(relative_pose_error(pairs, 10.0).translation_m.rmse, 0.1, 1e-9);
  const KittiErrors errors = kitti_errors(pairs, {100.0, 200.0, 400.0}, 1);
  EXPECT_NEAR(errors.translation_percent, 1.0, 1e-9);
  EXPECT_NEAR(errors.rotation_deg_per_100m, 0.0, 1e-9);
  EXPECT_EQ(errors.lengths_m, (std::vector<double>{100.0, 200.0}));
  EXPECT_EQ(errors.segments, 201U + 101U);
}

// A heading that drifts by 0.01 degrees per metre: 1 degree per 100 m.
TEST(RelativeErrors, OfADriftingHeading) {
  Trajectory turning = straight(201);
  for (int i = 0; i < 201; ++i) {
    turning.poses[i].pose.rotation = exp_so3({0.0, 0.0, 0.01 * i * M_PI / 180.0});
  }
  const KittiErrors errors = kitti_errors(associate(straight(201), turning), {100.0}, 10);
  EXPECT_NEAR(errors.rotation_deg_per_100m, 1.0, 1e-9);
  EXPECT_EQ(errors.segments, 11U);
}

// KITTI's segments are too long for short drives.
TEST(RelativeErrors, UseTheSegmentsThatFitIntoTheDrive) {
  const auto lengths_of = [](int metres) {
    return usual_segment_lengths(associate(straight(metres + 1), straight(metres + 1)));
  };
  EXPECT_EQ(lengths_of(399).front(), 50.0);
  EXPECT_EQ(lengths_of(399).back(), 200.0);
  EXPECT_EQ(lengths_of(400).front(), 100.0);
  EXPECT_EQ(lengths_of(400).back(), 800.0);
  EXPECT_EQ(usual_segment_lengths({}).front(), 50.0);
}

TEST(RelativeErrors, AreZeroWhereNoSegmentFits) {
  const auto pairs = associate(straight(20), straight(20));
  const KittiErrors errors = kitti_errors(pairs, {50.0}, 1);
  EXPECT_EQ(errors.segments, 0U);
  EXPECT_EQ(errors.translation_percent, 0.0);
  EXPECT_TRUE(errors.lengths_m.empty());
}

TEST(Associate, InterpolatesTheTruth) {
  Trajectory estimate;
  estimate.poses.push_back({from_seconds(2.25), Pose::Identity()});
  const auto pairs = associate(straight(10), estimate, 1.5);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_NEAR(pairs[0].truth.translation.x(), 2.25, 1e-12);
}

TEST(Associate, NeverExtrapolatesNorBridgesGaps) {
  Trajectory estimate;
  estimate.poses.push_back({from_seconds(-0.5), Pose::Identity()});
  estimate.poses.push_back({from_seconds(2.5), Pose::Identity()});
  estimate.poses.push_back({from_seconds(9.5), Pose::Identity()});
  EXPECT_TRUE(associate(straight(10), estimate, 0.5).empty());
}

TEST(Associate, TellsWhatItLeavesOutAndWhy) {
  Trajectory estimate;
  for (const double seconds : {-0.5, 2.0, 2.5, 2.6, 9.0, 9.5}) {
    estimate.poses.push_back({from_seconds(seconds), Pose::Identity()});
  }
  const LeftOut counts = left_out(straight(10), estimate);
  EXPECT_EQ(counts.outside, 2U);
  EXPECT_EQ(counts.in_gaps, 2U);
  EXPECT_EQ(associate(straight(10), estimate).size(), 2U);
  EXPECT_EQ(reason_of(counts, "the truth"),
            "2 lie in gaps of the truth longer than 0.5 s, 2 lie before or after the truth");
  EXPECT_EQ(remedy_for(counts), "give a denser trajectory");
  EXPECT_EQ(remedy_for({2, 0}), "check the clocks of both");
  EXPECT_EQ(reason_of({}, "the truth"), "");
}

TEST(Associate, RefusesUnequalLengthsWithoutStamps) {
  Trajectory estimate = straight(9);
  estimate.has_stamps = false;
  EXPECT_THROW(associate(straight(10), estimate), InputError);
}

}  // namespace
}  // namespace lidar_mapping::evaluation
