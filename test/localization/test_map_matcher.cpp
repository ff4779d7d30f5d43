// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/voxel_index.hpp"

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
  ScanPointSampler sampler_;
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

/// A level plate of 20 m at this height as a cloud in base_link.
PointCloud plate_seen_from(const Pose& T_map_base, float height) {
  PointCloud cloud;
  for (float x = -10.0F; x < 10.0F; x += 0.25F) {
    for (float y = -10.0F; y < 10.0F; y += 0.25F) {
      const Eigen::Vector3d p = T_map_base.inverse() * Eigen::Vector3d(x, y, height);
      Point point;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

// A car park: the ceiling of the lower storey is 0.25 m below the floor of the upper one. A vehicle
// on the upper one was placed 0.1 m too low.
TEST(MapSurfaces, KeepTheSidesOfASlabApart) {
  MapSurfaces surfaces(1 << 12);
  const Pose lower = planar(0.0, 0.0, 0.0);
  Pose upper = lower;
  upper.translation.z() = 3.6;
  const Eigen::Vector3d p_base_lidar(0.0, 0.0, 1.7);
  surfaces.insert(plate_seen_from(lower, 3.35F), lower, p_base_lidar);
  surfaces.insert(plate_seen_from(upper, 3.6F), upper, p_base_lidar);
  const Eigen::Vector3f point =
      (Eigen::Vector3d(2.5, 2.5, 3.6) - surfaces.fine().origin()).cast<float>();
  const VoxelIndex cell = voxel_index(point / static_cast<float>(surfaces.fine().resolution()));
  const auto plane = surfaces.fine().plane(cell, surfaces.fine().slot_of(cell),
                                           Eigen::Vector3f(-2.5F, -2.5F, 1.7F));
  ASSERT_GT(plane.normal.norm(), 0.0F);
  EXPECT_NEAR(plane.offset / plane.normal.z(), point.z(), 0.01F);
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

TEST_F(Matching, ContradictsAtAWrongPlaceAndIsUnknownOutsideTheMap) {
  const Pose here = planar(10.0, 1.0, 0.0);
  EXPECT_EQ(evidence_of(match(here, planar(-25.0, 0.0, 0.0), 0.2)), Evidence::kContradicts);
  EXPECT_EQ(evidence_of(match(here, planar(10.0, 1.0, 0.0, 50.0), 0.2)), Evidence::kUnknown);
}

TEST_F(Matching, ChangesTheOddsOfAPlaceByTheEvidenceOfTheScan) {
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

/// Scans of one place, of which the map shows a part.
class PartialAgreement : public Matching {
 protected:
  PartialAgreement() : scan_(scan_at(planar(10.0, 1.0, 0.1))) { choose_point(); }

  /// The scan with a hundred points above the ground: so many of them are one point of a wall, the
  /// others hang in the air where the map has nothing. The match depends on none of them.
  ScanPoints showing(std::size_t percent) const {
    std::vector<Eigen::Vector3f> points(100, Eigen::Vector3f(0.0F, 0.0F, 35.0F));
    std::fill_n(points.begin(), percent, point_);
    ScanPoints scan = scan_;
    scan.structure = ndt_points(points, scan_.all.viewpoint());
    return scan;
  }
  /// The scan of a covered sensor, which tells nothing.
  ScanPoints covered() const {
    ScanPoints scan = scan_;
    scan.near = ndt_points({point_}, scan_.all.viewpoint());
    return scan;
  }
  static Hypothesis start() { return place_at(planar(10.15, 0.9, 0.11)); }
  /// What such a share is worth a metre after all was shown over `way` metres.
  Evidence evidence_after(double way, std::size_t percent) {
    Hypothesis place = start();
    EXPECT_EQ(place.update(showing(100), surfaces_, matcher_, way), Evidence::kAgrees);
    return place.update(showing(percent), surfaces_, matcher_, 1.0);
  }
  /// What it is worth after an interruption and `way` metres with the same share.
  Evidence evidence_after_interruption(double way, std::size_t percent) {
    Hypothesis place = start();
    EXPECT_EQ(place.update(showing(100), surfaces_, matcher_, 1.0), Evidence::kAgrees);
    EXPECT_EQ(place.update(covered(), surfaces_, matcher_, 1.0), Evidence::kUnknown);
    EXPECT_EQ(place.update(showing(percent), surfaces_, matcher_, way), Evidence::kUnconfirmed);
    return place.update(showing(percent), surfaces_, matcher_, 1.0);
  }

 private:
  /// A point that lies on a surface of the map, so that its weight is nearly one.
  void choose_point() {
    const registration::NdtPoints& seen = scan_.structure;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      point_ = Eigen::Vector3f(seen.x()[i], seen.y()[i], seen.z()[i]);
      Hypothesis place = start();
      place.update(showing(100), surfaces_, matcher_, 1.0);
      const double at_first = place.match().agreement.agreement;
      place.update(showing(100), surfaces_, matcher_, 1.0);
      if (std::min(at_first, place.match().agreement.agreement) > 0.95) return;
    }
    ADD_FAILURE() << "no point of the scan lies on a surface";
  }

  ScanPoints scan_;
  Eigen::Vector3f point_ = Eigen::Vector3f::Zero();
};

// Streets have walls on both sides: what agrees in part may be another one.
TEST_F(PartialAgreement, HasToBeSixTenthsOfTheUsualOne) {
  EXPECT_EQ(evidence_after(20.0, 65), Evidence::kAgrees);
  EXPECT_EQ(evidence_after(20.0, 55), Evidence::kUnknown);
}

// After 15 m the usual agreement is 0.75 of all, of which 0.6 are 0.45.
TEST_F(PartialAgreement, IsComparedWithTheLastTwentyMetres) {
  EXPECT_EQ(evidence_after(15.0, 50), Evidence::kAgrees);
  EXPECT_EQ(evidence_after(15.0, 40), Evidence::kUnknown);
  EXPECT_EQ(evidence_after(60.0, 65), Evidence::kAgrees) << "no more than all was shown";
}

// Where too little stands for a verification the way has to do.
TEST_F(PartialAgreement, ConfirmsAPlaceAfterThirtyMetres) {
  EXPECT_EQ(evidence_after_interruption(31.0, 60), Evidence::kAgrees);
  EXPECT_EQ(evidence_after_interruption(29.0, 60), Evidence::kUnconfirmed);
}

TEST_F(PartialAgreement, ConfirmsNothingBelowAHalf) {
  EXPECT_EQ(evidence_after_interruption(31.0, 45), Evidence::kUnconfirmed);
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

// A single scan has more Gaussians than the smallest table has room for.
TEST(MapSurfaces, LoseNoPointWhereTheRoomIsTooSmall) {
  const ToyWorld world = make_town(60.0, 48.0, 3);
  MapSurfaces small(256), large(1 << 16);
  EXPECT_EQ(small.bytes(), (256U + 64U) * sizeof(registration::VoxelSums));
  for (MapSurfaces* surfaces : {&small, &large}) {
    surfaces->insert(world.scan(Pose::Identity(), 1), Pose::Identity(), ToyWorld::sensor());
    EXPECT_EQ(surfaces->fine().dropped_points() + surfaces->coarse().dropped_points(), 0U);
  }
  EXPECT_GT(large.gaussians(), 256U);
  EXPECT_EQ(small.gaussians(), large.gaussians());
  EXPECT_LT(small.bytes(), large.bytes());
}

}  // namespace
}  // namespace lidar_mapping::localization::test
