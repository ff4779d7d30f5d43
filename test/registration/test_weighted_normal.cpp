// SPDX-License-Identifier: BSD-3-Clause
// How sure the plane of a voxel is, and the voxels of a whole cloud.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "near.hpp"
#include "voxels/voxel_target.hpp"
#include "voxels/weighted_normal.hpp"

namespace lidar_mapping::registration {
namespace {

using test::near;

/// Points whose thinnest axis is z, then y, then x, with these variances along them (m^2).
Gaussian blob(double zz, double yy, double xx, int count = 20) {
  Gaussian gaussian;
  gaussian.covariance = Eigen::Vector3d(xx, yy, zz).asDiagonal();
  gaussian.count = count;
  return gaussian;
}

double weight(const Gaussian& gaussian) {
  return weighted_normal(gaussian, PlaneModel{}, 0.0).norm();
}

TEST(WeightedNormal, IsTheThinnestAxis) {
  const Eigen::Vector3d axis = weighted_normal(blob(0.0, 0.16, 0.25), PlaneModel{}, 0.0);
  EXPECT_NEAR(std::abs(axis.normalized().z()), 1.0, 1e-6);
}

// 1.5 points of a blob of 0.15 m are the prior beside 19 free ones, and 0.015 m the noise of each.
TEST(WeightedNormal, HasTheInverseOfTheThicknessAsItsLength) {
  const double prior = 1.5 * 0.15 * 0.15, noise = 0.015 * 0.015;
  EXPECT_NEAR(weight(blob(0.0, 0.16, 0.25)), 1.0 / std::sqrt(prior / 20.5 + noise), 1e-3);
  EXPECT_NEAR(weight(blob(0.01, 0.16, 0.25)), 1.0 / std::sqrt((19.0 * 0.01 + prior) / 20.5 + noise),
              1e-3);
  EXPECT_NEAR(weight(blob(0.0, 0.16, 0.25, 200)), 1.0 / std::sqrt(prior / 200.5 + noise), 1e-3);
}

// The axis of a line is arbitrary around it.
TEST(WeightedNormal, FadesWithTheRoundnessOfThePlane) {
  const double full = weight(blob(0.0, 0.5, 1.0));
  EXPECT_NEAR(weight(blob(0.0, 0.2, 1.0)), full, 1e-3);
  EXPECT_NEAR(weight(blob(0.0, 0.105, 1.0)), 0.5 * full, 1e-3) << "half way from 0.01 to 0.2";
  EXPECT_NEAR(weight(blob(0.0, 0.01, 1.0)), 0.0, 1e-3);
  EXPECT_NEAR(weight(blob(0.0, 0.005, 1.0)), 0.0, 1e-9);
}

TEST(WeightedNormal, FadesWithTheBreadthOfThePlane) {
  const double full = weight(blob(0.0, 0.5, 1.0));
  EXPECT_NEAR(weight(blob(0.0, 0.05 * 0.05, 0.003)), full, 0.01);
  EXPECT_NEAR(weight(blob(0.0, 0.04 * 0.04, 0.003)), 0.5 * full, 0.01);
  EXPECT_NEAR(weight(blob(0.0, 0.029 * 0.029, 0.003)), 0.0, 1e-9);
}

TEST(WeightedNormal, OfASinglePlaceIsZero) { EXPECT_EQ(weight(blob(0.0, 0.0, 0.0)), 0.0); }

/// The same turned by 45 degrees about x, so that the thinnest axis is half upright.
Eigen::Vector3d oblique_normal(Gaussian gaussian, double ring_isolation) {
  const Eigen::Matrix3d R = exp_so3({0.25 * M_PI, 0.0, 0.0}).toRotationMatrix();
  gaussian.covariance = R * gaussian.covariance * R.transpose();
  return weighted_normal(gaussian, PlaneModel{}, ring_isolation).cwiseAbs();
}

TEST(WeightedNormal, OfABushBetweenIsolatedRingsIsLevel) {
  // Thickness to breadth: 0.3 and more is a bush, 0.1 and less is a plane.
  const Gaussian bush = blob(0.09 * 0.16, 0.16, 0.25);
  const Gaussian between = blob(0.04 * 0.16, 0.16, 0.25);
  const Gaussian plane = blob(0.01 * 0.16, 0.16, 0.25);
  const auto steepness = [](const Gaussian& gaussian, double ring_isolation) {
    const Eigen::Vector3d normal = oblique_normal(gaussian, ring_isolation);
    EXPECT_NEAR(normal.y(), oblique_normal(gaussian, 0.0).y(), 1e-9) << "as if without rings";
    return normal.z() / normal.y();
  };
  EXPECT_NEAR(steepness(bush, 0.0), 1.0, 1e-4);
  EXPECT_NEAR(steepness(bush, 0.6), 0.4, 1e-4);
  EXPECT_NEAR(steepness(bush, 1.0), 0.0, 1e-4);
  EXPECT_NEAR(steepness(between, 1.0), 0.5, 1e-4);
  EXPECT_NEAR(steepness(plane, 1.0), 1.0, 1e-4);
}

TEST(ToPcl, LeavesOutPointsThatAreNotFinite) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  PointCloud cloud;
  cloud.points.push_back({1.0F, 2.0F, 3.0F, 9.0F});
  cloud.points.push_back({kNan, 0.0F, 0.0F, 0.0F});
  cloud.points.push_back({0.0F, kInfinity, 0.0F, 0.0F});
  cloud.points.push_back({0.0F, 0.0F, -kInfinity, 0.0F});
  cloud.points.push_back({4.0F, 5.0F, 6.0F, kNan});
  const PclCloud::Ptr points = to_pcl(cloud);
  ASSERT_EQ(points->size(), 2U);
  EXPECT_EQ((*points)[0].y, 2.0F);
  EXPECT_EQ((*points)[1].z, 6.0F);
}

TEST(MiddleOf, IsTheMean) {
  PclCloud cloud;
  EXPECT_TRUE(near(middle_of(cloud), Eigen::Vector3d(0.0, 0.0, 0.0), 1e-12));
  cloud.push_back(pcl::PointXYZ(1.0F, 2.0F, 3.0F));
  cloud.push_back(pcl::PointXYZ(2.0F, 4.0F, -3.0F));
  EXPECT_TRUE(near(middle_of(cloud), Eigen::Vector3d(1.5, 3.0, 0.0), 1e-12));
}

// 4000 voxels are more than the table has at least.
TEST(VoxelTarget, HasAllPointsOfACloudFarAway) {
  const Eigen::Vector3d corner(3000.0, -2000.0, 100.0);
  PclCloud cloud;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 100; ++k) {
      for (const float dz : {0.2F, 0.4F, 0.6F}) {
        cloud.push_back(pcl::PointXYZ(static_cast<float>(corner.x() + i + 0.5),
                                      static_cast<float>(corner.y() + k + 0.5),
                                      static_cast<float>(corner.z()) + dz));
      }
    }
  }
  const GaussianVoxelMap map = voxel_target(cloud, 1.0, PlaneModel{});
  EXPECT_EQ(map.dropped_points(), 0U);
  EXPECT_EQ(map.size(), 4000U);
  EXPECT_TRUE(near(map.origin(), middle_of(cloud), 0.9)) << "within half of a voxel's diagonal";
  const VoxelIndex first = (corner - map.origin()).array().round().matrix().cast<int>();
  const Gaussian gaussian = map.gaussian(first);
  EXPECT_EQ(gaussian.count, 3);
  EXPECT_TRUE(near(gaussian.mean + map.origin(), corner + Eigen::Vector3d(0.5, 0.5, 0.4), 1e-3));
}

}  // namespace
}  // namespace lidar_mapping::registration
