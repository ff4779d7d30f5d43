// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "hypothesis.hpp"
#include "near.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::near;

class Matching : public testing::Test {
 protected:
  Matching() : world_(make_town(100.0, 48.0, 3)), surfaces_(1 << 17) {
    for (const Pose& pose : along({{-60.0, 0.0}, {60.0, 0.0}})) {
      surfaces_.insert(world_.scan(pose, 1), pose, ToyWorld::sensor());
    }
  }
  ScanPoints scan_at(const Pose& pose) {
    return sampler_.sample(world_.scan(pose, 9), ToyWorld::sensor());
  }
  MapMatch match(const Pose& truth, const Pose& guess, double sigma) {
    return matcher_.match(scan_at(truth), surfaces_, {guess, diagonal_covariance(sigma, 0.05)});
  }
  /// A place that is known to 0.2 m and 0.05 rad.
  static Hypothesis place_at(const Pose& guess) {
    return Hypothesis(PoseEstimate{guess, diagonal_covariance(0.2, 0.05)});
  }
  /// By how much a scan, `way` metres after the one before, changes the odds of such a place.
  double change_of_odds(const Pose& truth, const Pose& guess, double way) {
    Hypothesis place = place_at(guess);
    const double before = place.log_odds();
    place.update(scan_at(truth), surfaces_, matcher_, way);
    return place.log_odds() - before;
  }

  const ToyWorld world_;
  MapSurfaces surfaces_;
  ScanSampler sampler_;
  MapMatcher matcher_;
};

TEST_F(Matching, FindsThePoseAndItsCovariance) {
  const Pose truth = planar(10.0, 1.0, 0.1);
  const MapMatch found = match(truth, planar(10.15, 0.9, 0.11), 0.2);
  EXPECT_TRUE(found.converged);
  EXPECT_TRUE(near(found.estimate.T_map_base, truth, 0.05, 0.003));
  EXPECT_TRUE(is_valid_covariance(found.estimate.covariance));
  EXPECT_EQ(evidence_of(found), Evidence::kAgrees);
}

TEST_F(Matching, FindsAPoseFurtherAwayIfThePredictionIsUncertain) {
  const Pose truth = planar(10.0, 1.0, 0.1);
  const MapMatch found = match(truth, planar(11.1, 0.2, 0.14), 1.5);
  EXPECT_TRUE(near(found.estimate.T_map_base, truth, 0.05, 0.003));
}

TEST_F(Matching, DependsOnThePredictionWherePointsSayNothing) {
  const MapMatch sure = match(planar(10.0, 1.0, 0.0), planar(10.3, 1.0, 0.0), 1e-3);
  EXPECT_TRUE(near(sure.estimate.T_map_base.translation, Eigen::Vector3d(10.3, 1.0, 0.0), 0.05));
}

TEST_F(Matching, ContradictsAtAWrongPlaceAndDoesNotKnowOthers) {
  const Pose here = planar(10.0, 1.0, 0.0);
  EXPECT_EQ(evidence_of(match(here, planar(-25.0, 0.0, 0.0), 0.2)), Evidence::kContradicts);
  EXPECT_EQ(evidence_of(match(here, planar(10.0, 1.0, 0.0, 50.0), 0.2)), Evidence::kUnknown);
}

TEST_F(Matching, ChangesTheOddsOfAPlaceByWhatTheScanSays) {
  const Pose turned = planar(10.0, 1.0, 0.1), beside = planar(10.15, 0.9, 0.11);
  EXPECT_NEAR(change_of_odds(turned, beside, 1.0), 1.5, 1e-12);
  EXPECT_NEAR(change_of_odds(turned, beside, 8.0), 1.5, 1e-12) << "no more than a metre";
  EXPECT_NEAR(change_of_odds(turned, beside, 0.0), 0.15, 1e-12) << "at rest";
  const Pose here = planar(10.0, 1.0, 0.0);
  EXPECT_NEAR(change_of_odds(here, planar(-25.0, 0.0, 0.0), 1.0), -1.0, 1e-12);
  EXPECT_NEAR(change_of_odds(here, planar(10.0, 1.0, 0.0, 50.0), 1.0), -0.02, 1e-12);
}

// A place that odometry has led to may be a wrong one that agrees as well.
TEST_F(Matching, DoesNotFollowAPlaceAgainBeforeItIsVerified) {
  const Pose truth = planar(10.0, 1.0, 0.1);
  const ScanPoints scan = scan_at(truth);
  const PointCloud cloud = world_.scan(truth, 9);
  PointCloud covered;
  for (std::size_t i = 0; i < cloud.size(); i += cloud.size() / 40) {
    covered.points.push_back(cloud.points[i]);
  }
  Hypothesis place = place_at(planar(10.15, 0.9, 0.11));
  const auto evidence_of_scan = [&](const ScanPoints& points) {
    return place.update(points, surfaces_, matcher_, 1.0);
  };
  EXPECT_EQ(evidence_of_scan(scan), Evidence::kAgrees);
  EXPECT_EQ(evidence_of_scan(sampler_.sample(covered, ToyWorld::sensor())), Evidence::kUnknown);
  EXPECT_EQ(evidence_of_scan(scan), Evidence::kUnconfirmed);
  place.verify(place.match().estimate);
  EXPECT_EQ(evidence_of_scan(scan), Evidence::kAgrees);
}

TEST_F(Matching, IsAsGoodFarFromTheOrigin) {
  const Pose far = planar(80'000.0, -40'000.0, 0.0);
  MapSurfaces surfaces(1 << 17);
  for (const Pose& pose : along({{-60.0, 0.0}, {60.0, 0.0}})) {
    surfaces.insert(world_.scan(pose, 1), far * pose, ToyWorld::sensor());
  }
  const Pose truth = planar(10.0, 1.0, 0.1);
  const MapMatch found = matcher_.match(
      scan_at(truth), surfaces, {far * planar(10.15, 0.9, 0.11), diagonal_covariance(0.2, 0.05)});
  EXPECT_TRUE(near(found.estimate.T_map_base, far * truth, 0.05, 0.003));
}

TEST(MapSurfaces, SaysWhenItsRoomIsTooSmall) {
  const ToyWorld world = make_town(60.0, 48.0, 3);
  MapSurfaces small(256), large(1 << 16);
  for (MapSurfaces* surfaces : {&small, &large}) {
    surfaces->insert(world.scan(Pose::Identity(), 1), Pose::Identity(), ToyWorld::sensor());
  }
  EXPECT_TRUE(small.is_overfull());
  EXPECT_FALSE(large.is_overfull());
}

}  // namespace
}  // namespace lidar_mapping::localization::test
