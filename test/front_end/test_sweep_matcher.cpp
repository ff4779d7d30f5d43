// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "matched_sweeps.hpp"
#include "matching/sweep_matcher.hpp"
#include "near.hpp"
#include "scenes.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionBelief;
using registration::NdtMatch;
using registration::NdtPoints;
using registration::NeighborSearch;

SampledPoints sampled(const PointCloud& cloud) {
  std::vector<std::uint32_t> all(cloud.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  SampledPoints points;
  points.assign(cloud, all, 0.0);
  return points;
}

/// The scene as a sensor at this pose sees it in one instant.
NdtPoints seen_from(const Pose& T_map_sensor, const PointCloud& scene) {
  const SampledPoints points = sampled(transformed(scene, T_map_sensor.inverse()));
  NdtPoints result;
  result.assign(points.x, points.y, points.z, points.s);
  return result;
}

/// A corridor along x whose ends are out of sight, 20 m long as it is seen, `length` in the map.
PointCloud corridor(unsigned seed, double length, std::size_t points) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  PointCloud cloud;
  for (std::size_t i = 0; i < points; ++i) {
    Eigen::Vector3d p(0.5 * length * unit(engine), 2.3 * unit(engine), 1.4 * unit(engine));
    if (i % 3 == 0) p.y() = std::copysign(2.3, p.y());
    if (i % 3 != 0) p.z() = std::copysign(1.4, p.z());
    p += Eigen::Vector3d(noise(engine), noise(engine), noise(engine));
    cloud.points.push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0.0F});
  }
  return cloud;
}

Pose pose_at(double x, double y, double yaw = 0.0) {
  return {exp_so3({0.0, 0.0, yaw}), {x, y, 0.0}};
}

/// The belief in a pose, at rest.
MotionBelief belief_in(const Pose& pose, double metres = 0.1, double radians = 0.01) {
  MotionBelief belief;
  belief.state.T_map_sensor = pose;
  belief.information = match_covariance(metres, radians, 1.0, 0.1).inverse();
  return belief;
}

Prediction prediction_of(const Pose& pose) {
  return {belief_in(pose), belief_in(pose), belief_in(pose, 5.0, 0.5)};
}

class SweepMatcherAtACorner : public testing::Test {
 protected:
  SweepMatcherAtACorner() {
    map_.insert(sampled(test::street_corner(1, 30000, 0.02)), {});
    judge_.learn(matcher_.refine(points_, map_, belief_in(kTruth), {kTruth, Vector6d::Zero()}));
  }

  const Pose kTruth = pose_at(1.0, -0.5, 0.1);
  const NdtPoints points_ = seen_from(kTruth, test::street_corner(2, 4000, 0.02));
  LocalMap map_{1.0, 110.0};
  MatchJudge judge_{50.0};
  SweepMatcher matcher_{NeighborSearch::kDirect1};
};

TEST_F(SweepMatcherAtACorner, FollowsAGoodPredictionToThePose) {
  const Pose near_by = kTruth * pose_at(0.15, -0.1, 0.01);
  const auto found = matcher_.find(points_, map_, judge_, prediction_of(near_by), {});
  EXPECT_FALSE(found.rescued);
  EXPECT_TRUE(found.degenerate_directions.empty());
  EXPECT_TRUE(test::near(found.match.state.T_map_sensor, kTruth, 0.03, 0.003));
  EXPECT_EQ(found.match.parts.size(), registration::kNdtParts);
}

TEST_F(SweepMatcherAtACorner, SearchesAroundAPredictionInDoubt) {
  const Pose far_off = kTruth * pose_at(-3.0, 0.8, -0.4);
  const auto found = matcher_.find(points_, map_, judge_, prediction_of(far_off), {});
  EXPECT_TRUE(found.rescued);
  EXPECT_TRUE(test::near(found.match.state.T_map_sensor, kTruth, 0.03, 0.003));
}

TEST_F(SweepMatcherAtACorner, SearchesAroundAnchors) {
  const Pose lost = kTruth * pose_at(0.0, 24.0, 1.2);
  Prediction prediction = prediction_of(lost);
  prediction.high_noise = belief_in(lost, 50.0, 1.0);
  const auto alone = matcher_.find(points_, map_, judge_, prediction, {});
  EXPECT_FALSE(test::near(alone.match.state.T_map_sensor, kTruth, 1.0))
      << "out of reach, or this test shows nothing";
  const auto found =
      matcher_.find(points_, map_, judge_, prediction, {kTruth * pose_at(-2.0, 0.5, 0.2)});
  EXPECT_TRUE(found.rescued);
  EXPECT_TRUE(test::near(found.match.state.T_map_sensor, kTruth, 0.05, 0.005));
}

// The search costs more than ten times as much as a match.
TEST_F(SweepMatcherAtACorner, MatchesCoarselyFirstIfTheQuickTestFails) {
  const auto loose = [](const Pose& pose) {
    const MotionBelief belief = belief_in(pose, 1.0, 0.1);
    return Prediction{belief, belief, belief};
  };
  const Pose off = kTruth * pose_at(1.3, 1.0, 0.12);
  const NdtMatch fine = matcher_.refine(points_, map_, loose(off).nominal, {off, Vector6d::Zero()});
  ASSERT_FALSE(test::near(fine.state.T_map_sensor, kTruth, 0.1)) << "or this test shows nothing";
  for (int i = 0; i < 30; ++i) matcher_.find(points_, map_, judge_, loose(kTruth), {});
  const auto found = matcher_.find(points_, map_, judge_, loose(off), {});
  EXPECT_FALSE(found.rescued);
  EXPECT_TRUE(test::near(found.match.state.T_map_sensor, kTruth, 0.03, 0.003));
}

TEST_F(SweepMatcherAtACorner, SearchGivesTheBestOfItsStartsInAnyOrder) {
  std::vector<registration::MotionState> starts;
  for (const double x : {-9.0, 8.0, -6.0, 0.4, 5.0, -3.5}) {
    starts.push_back({kTruth * pose_at(x, 0.3, 0.05), Vector6d::Zero()});
  }
  const MotionBelief anywhere = belief_in(kTruth, 20.0, 1.0);
  for (int turn = 0; turn < 6; ++turn) {
    const NdtMatch found = matcher_.search(points_, map_, anywhere, starts);
    EXPECT_TRUE(test::near(found.state.T_map_sensor, kTruth, 0.03, 0.003)) << turn;
    std::rotate(starts.begin(), starts.begin() + 1, starts.end());
  }
}

TEST_F(SweepMatcherAtACorner, LeavesGivenDirectionsToThePrediction) {
  const Pose start = kTruth * pose_at(0.3, 0.2);
  const auto off_in = [&](const NdtMatch& match) -> Eigen::Vector3d {
    return kTruth.inverse() * match.state.T_map_sensor.translation;
  };
  const auto found = matcher_.match_without(points_, map_, belief_in(start),
                                            {start, Vector6d::Zero()}, {Eigen::Vector3d::UnitX()});
  ASSERT_EQ(found.degenerate_directions.size(), 1U);
  EXPECT_FALSE(found.rescued);
  EXPECT_NEAR(off_in(found.match).x(), 0.3, 0.1) << "of the prediction";
  EXPECT_NEAR(off_in(found.match).y(), 0.0, 0.1) << "of the points";
  const NdtMatch with = matcher_.refine(points_, map_, belief_in(start), {start, Vector6d::Zero()});
  EXPECT_NEAR(off_in(with).x(), 0.0, 0.05);
}

TEST(SweepMatcher, TakesWhatThePointsDoNotObserveFromItsOwnPrediction) {
  LocalMap map(1.0, 110.0);
  map.insert(sampled(corridor(1, 60.0, 60000)), {});
  const NdtPoints points = seen_from(Pose(), corridor(2, 20.0, 5000));
  const Prediction prediction{belief_in(pose_at(0.0, 0.1)), belief_in(pose_at(0.4, 0.1), 0.02),
                              belief_in(pose_at(0.0, 0.1), 5.0, 0.5)};
  SweepMatcher matcher(NeighborSearch::kDirect1);
  const auto found = matcher.find(points, map, MatchJudge(50.0), prediction, {});
  ASSERT_EQ(found.degenerate_directions.size(), 1U);
  EXPECT_GT(std::abs(found.degenerate_directions[0].x()), 0.99);
  const Eigen::Vector3d p = found.match.state.T_map_sensor.translation;
  EXPECT_NEAR(p.x(), 0.4, 0.05);
  EXPECT_NEAR(p.y(), 0.0, 0.02);
}

TEST(SweepMatcher, UsesTheCoarseMapWhileTheFineOneIsSparse) {
  LocalMap sparse(1.0, 110.0);
  sparse.insert(sampled(test::street_corner(1, 3000, 0.02)), {});
  const NdtPoints points = seen_from(Pose(), test::street_corner(2, 4000, 0.02));
  registration::NdtMatcher ndt;
  const double fine = ndt.evaluate(points, sparse.fine(), {}, {}).overlap;
  const double coarse = ndt.evaluate(points, sparse.coarse(), {}, {}).overlap;
  ASSERT_LT(fine, 0.24) << "or this test shows nothing";
  ASSERT_GT(coarse, 0.3);
  SweepMatcher matcher(NeighborSearch::kDirect1);
  const Pose start = pose_at(0.1, 0.1, 0.01);
  const auto found = matcher.find(points, sparse, MatchJudge(50.0), prediction_of(start), {});
  EXPECT_NEAR(found.match.overlap, coarse, 0.1);
}

}  // namespace
}  // namespace lidar_mapping::front_end
