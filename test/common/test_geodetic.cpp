// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/geodetic.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping {
namespace {

// WGS 84, by definition.
constexpr double kEquator = 6378137.0;               // m, radius
constexpr double kFlattening = 1.0 / 298.257223563;  // of the ellipsoid

/// Radii of curvature along a meridian and across it, m.
double along_meridian(double latitude) {
  const double e2 = kFlattening * (2.0 - kFlattening);
  return kEquator * (1.0 - e2) / std::pow(1.0 - e2 * std::pow(std::sin(latitude), 2), 1.5);
}
double across_meridian(double latitude) {
  const double e2 = kFlattening * (2.0 - kFlattening);
  return kEquator / std::sqrt(1.0 - e2 * std::pow(std::sin(latitude), 2));
}

TEST(GeodeticPositions, OfTheOriginIsTheDatum) {
  const GeodeticDatum datum = {49.0, 8.4, 115.0};
  const auto positions = geodetic_positions(datum, {Eigen::Vector3d(0.0, 0.0, 0.0)});
  ASSERT_EQ(positions.size(), 1U);
  EXPECT_NEAR(positions[0].x(), 8.4, 1e-11) << "longitude comes first";
  EXPECT_NEAR(positions[0].y(), 49.0, 1e-11);
  EXPECT_NEAR(positions[0].z(), 115.0, 1e-6);
}

// A metre is so many degrees as the radii of curvature tell.
TEST(GeodeticPositions, FollowTheCurvatureOfTheEllipsoid) {
  for (const double latitude_deg : {0.0, 49.0, -33.0}) {
    const GeodeticDatum datum = {latitude_deg, 8.4, 0.0};
    const auto positions =
        geodetic_positions(datum, {Eigen::Vector3d(10.0, 0.0, 0.0), Eigen::Vector3d(0.0, 10.0, 0.0),
                                   Eigen::Vector3d(0.0, 0.0, 10.0)});
    ASSERT_EQ(positions.size(), 3U);
    const double latitude = latitude_deg * kRadPerDeg;
    const double east = 10.0 / (across_meridian(latitude) * std::cos(latitude)) * kDegPerRad;
    const double north = 10.0 / along_meridian(latitude) * kDegPerRad;
    EXPECT_NEAR(positions[0].x() - 8.4, east, 1e-5 * east) << latitude_deg;
    EXPECT_NEAR(positions[0].y() - latitude_deg, 0.0, 1e-5 * north) << latitude_deg;
    EXPECT_NEAR(positions[1].y() - latitude_deg, north, 1e-5 * north) << latitude_deg;
    EXPECT_NEAR(positions[1].x() - 8.4, 0.0, 1e-5 * east) << latitude_deg;
    EXPECT_NEAR(positions[2].z(), 10.0, 1e-6) << latitude_deg;
  }
}

// The plane leaves the ellipsoid by the square of the distance over twice the radius.
TEST(GeodeticPositions, RiseAboveTheEllipsoidFarFromTheDatum) {
  const double far = 20000.0;
  const auto positions = geodetic_positions({0.0, 0.0, 50.0}, {Eigen::Vector3d(far, 0.0, 0.0)});
  const double radius = kEquator + 50.0;
  EXPECT_NEAR(positions.at(0).z(), std::hypot(radius, far) - kEquator, 1e-6);
  EXPECT_NEAR(positions.at(0).x(), std::atan2(far, radius) * kDegPerRad, 1e-11);
}

TEST(GeodeticPositions, OfNoPointsAreNone) {
  EXPECT_TRUE(geodetic_positions({49.0, 8.4, 115.0}, {}).empty());
}

}  // namespace
}  // namespace lidar_mapping
