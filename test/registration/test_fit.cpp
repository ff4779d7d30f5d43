// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "fit.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

pcl::Indices all_of(const PclCloud& cloud) {
  pcl::Indices indices;
  for (std::size_t i = 0; i < cloud.size(); ++i) indices.push_back(static_cast<pcl::index_t>(i));
  return indices;
}

/// Points 0.2 m apart in a square plane of 8 m with this height and slope along x.
PclCloud plane(float height, float slope = 0.0F) {
  PclCloud cloud;
  for (int i = -20; i <= 20; ++i) {
    for (int k = -20; k <= 20; ++k) {
      const float x = 0.2F * static_cast<float>(i), y = 0.2F * static_cast<float>(k);
      cloud.push_back({x, y, height + slope * x});
    }
  }
  return cloud;
}

/// Points around a place, spread by these standard lengths along x, y and z.
PclCloud ellipsoid(const Eigen::Vector3f& place, const Eigen::Vector3f& axes) {
  PclCloud cloud;
  for (const float x : {-1.0F, 1.0F}) {
    for (const float y : {-1.0F, 1.0F}) {
      for (const float z : {-1.0F, 1.0F}) {
        const Eigen::Vector3f p = place + axes.cwiseProduct(Eigen::Vector3f(x, y, z));
        cloud.push_back({p.x(), p.y(), p.z()});
      }
    }
  }
  return cloud;
}

std::optional<PlaneFit> plane_of(const PclCloud& cloud) { return fit_plane(cloud, all_of(cloud)); }

TEST(FitPlane, FindsPlaneAndNormal) {
  const auto found = plane_of(plane(1.0F, 0.5F));
  ASSERT_TRUE(found);
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.5, 0.0, 1.0).normalized();
  EXPECT_NEAR(std::abs(found->normal.dot(normal)), 1.0, 1e-9);
  EXPECT_TRUE(test::near(found->mean, Eigen::Vector3d(0.0, 0.0, 1.0), 1e-5));
}

TEST(FitPlane, KeepsDigitsFarFromTheOrigin) {
  const Eigen::Vector3f place(4096.0F, -8192.0F, 512.0F);
  const auto found = plane_of(ellipsoid(place, {0.5F, 0.5F, 0.0F}));
  ASSERT_TRUE(found);
  EXPECT_NEAR(std::abs(found->normal.z()), 1.0, 1e-6);
  EXPECT_TRUE(test::near(found->mean, place.cast<double>(), 1e-6));
}

/// The limits are ratios of variances, 0.05 in breadth and 0.1 in thickness.
TEST(FitPlane, RefusesLinesAndVolumes) {
  const Eigen::Vector3f place(1.0F, 2.0F, 3.0F);
  EXPECT_TRUE(plane_of(ellipsoid(place, {1.0F, 0.25F, 0.0F})));
  EXPECT_FALSE(plane_of(ellipsoid(place, {1.0F, 0.2F, 0.0F}))) << "0.04 as broad as long";
  EXPECT_TRUE(plane_of(ellipsoid(place, {1.0F, 1.0F, 0.3F})));
  EXPECT_FALSE(plane_of(ellipsoid(place, {1.0F, 1.0F, 0.33F}))) << "0.11 as thick as broad";
}

RegistrationResult fit_of(const PclCloud& target, const PclCloud& source, const Pose& T,
                          double max_range) {
  pcl::search::KdTree<pcl::PointXYZ> tree;
  tree.setInputCloud(target.makeShared());
  return evaluate_fit(tree, source, T, max_range);
}

Pose raised(double height) { return {Eigen::Quaterniond::Identity(), {0.0, 0.0, height}}; }

TEST(EvaluateFit, MeasuresTheDistanceToTheNearestPoints) {
  const RegistrationResult fit = fit_of(plane(0.0F), plane(0.0F), raised(0.1), 1.0);
  EXPECT_EQ(fit.T_target_source.translation, raised(0.1).translation);
  EXPECT_NEAR(fit.fitness, 0.01, 1e-6);
  EXPECT_EQ(fit.overlap, 1.0);
  EXPECT_EQ(fit.inlier_fraction, 1.0) << "0.1 m is less than a fifth of the range";
  EXPECT_EQ(fit_of(plane(0.0F), plane(0.0F), raised(0.3), 1.0).inlier_fraction, 0.0)
      << "0.3 m is more";
}

TEST(EvaluateFit, CountsOnlyWhatHasAPartner) {
  Pose aside = raised(0.0);
  aside.translation.x() = 4.1;  // 21 of 41 columns remain over the plane
  const RegistrationResult fit = fit_of(plane(0.0F), plane(0.0F), aside, 0.15);
  EXPECT_NEAR(fit.overlap, 21.0 / 41.0, 0.01);
  EXPECT_NEAR(fit.fitness, 0.01, 1e-5) << "half of the spacing to the nearest point";
  const RegistrationResult none = fit_of(plane(0.0F), plane(0.0F), raised(5.0), 1.0);
  EXPECT_EQ(none.fitness, 0.0);
  EXPECT_EQ(none.overlap, 0.0);
  EXPECT_EQ(none.inlier_fraction, 0.0);
  EXPECT_EQ(none.hessian, Matrix6d::Zero());
}

/// A line of points has no plane; then the distance to the nearest point decides.
TEST(EvaluateFit, TakesTheDistanceToAPointWhereThereIsNoSurface) {
  PclCloud line;
  for (int i = 0; i < 40; ++i) line.push_back({0.1F * static_cast<float>(i), 0.0F, 0.0F});
  EXPECT_EQ(fit_of(line, line, raised(0.45), 1.0).inlier_fraction, 1.0);
  EXPECT_EQ(fit_of(line, line, raised(0.55), 1.0).inlier_fraction, 0.0);
  EXPECT_EQ(fit_of(line, line, raised(0.45), 1.0).hessian, Matrix6d::Zero());
}

TEST(EvaluateFit, KnowsWhatAPlaneDetermines) {
  const Matrix6d hessian = fit_of(plane(0.0F), plane(0.0F), raised(0.01), 1.0).hessian;
  for (const int i : {2, 3, 4}) EXPECT_GT(hessian(i, i), 1.0) << i;  // height, roll, pitch
  for (const int i : {0, 1, 5}) EXPECT_NEAR(hessian(i, i), 0.0, 1e-6) << i;
}

/// The weight of a residual does not depend on how many others there are.
TEST(EvaluateFit, TakesAPartOfALargeCloud) {
  PclCloud source;
  for (int i = 0; i < 5; ++i) source += plane(0.0F);
  ASSERT_GT(source.size(), 5000U);
  const RegistrationResult fit = fit_of(plane(0.0F), source, raised(0.1), 1.0);
  EXPECT_EQ(fit.overlap, 1.0);
  const RegistrationResult small = fit_of(plane(0.0F), plane(0.0F), raised(0.1), 1.0);
  EXPECT_LT(fit.hessian(2, 2), 1.2 * small.hessian(2, 2)) << "at most 1000 points are used";
}

}  // namespace
}  // namespace lidar_mapping::registration
