// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "lidar_mapping/common/plane_fit.hpp"

namespace lidar_mapping {
namespace {

/// Corners of a rectangle of 4 m by 2 m along two axes.
PointMoments rectangle(const Eigen::Vector3d& mean, const Eigen::Vector3d& longer,
                       const Eigen::Vector3d& shorter) {
  PointMoments moments;
  for (const double u : {-2.0, 2.0}) {
    for (const double v : {-1.0, 1.0}) moments.add(mean + u * longer + v * shorter);
  }
  return moments;
}

TEST(PlaneFit, FindsPlaneAndSpreads) {
  const Eigen::Vector3d mean(30.0, -20.0, 1.0);
  const Eigen::Vector3d longer(0.6, 0.8, 0.0), shorter(0.0, 0.0, 1.0);
  const PlaneFit fit(rectangle(mean, longer, shorter));
  EXPECT_NEAR(std::abs(fit.normal.dot(longer.cross(shorter))), 1.0, 1e-12);
  EXPECT_TRUE(fit.mean.isApprox(mean, 1e-12));
  EXPECT_NEAR(fit.variances[0], 0.0, 1e-9);
  EXPECT_NEAR(fit.variances[1], 1.0, 1e-9);
  EXPECT_NEAR(fit.variances[2], 4.0, 1e-9);
}

TEST(PlaneFit, HasNoNegativeVarianceByRounding) {
  const Eigen::Vector3d mean(3000.0, 4000.0, 50.0);
  const PlaneFit fit(
      rectangle(mean, Eigen::Vector3d(0.8, 0.6, 0.0), Eigen::Vector3d(-0.6, 0.8, 0.0)));
  EXPECT_GE(fit.variances[0], 0.0);
}

}  // namespace
}  // namespace lidar_mapping
