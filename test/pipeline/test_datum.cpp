// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/pipeline/datum.hpp"

#include "near.hpp"

namespace lidar_mapping::pipeline {
namespace {

using test::near;

const GeodeticDatum kDatum{49.0, 8.4, 115.0};

// The axes of WGS 84 and the radii that follow from them.
constexpr double kMajorAxis = 6378137.0;       // m
constexpr double kEccentricity2 = 0.00669438;  // squared
double sine2() { return std::pow(std::sin(kDatum.latitude_deg * kRadPerDeg), 2); }
double east_west_radius() { return kMajorAxis / std::sqrt(1.0 - kEccentricity2 * sine2()); }
double north_south_radius() {
  return kMajorAxis * (1.0 - kEccentricity2) / std::pow(1.0 - kEccentricity2 * sine2(), 1.5);
}

TEST(EnuBetween, IsTheIdentityForOneDatum) {
  EXPECT_TRUE(near(enu_between(kDatum, kDatum), Pose::Identity(), 1e-15));
}

TEST(EnuBetween, HasTheOtherDatumWhereItLies) {
  const GeodeticDatum north{49.001, 8.4, 115.0};
  const double to_north = 0.001 * kRadPerDeg * (north_south_radius() + 115.0);
  EXPECT_TRUE(
      near(enu_between(kDatum, north).translation.head<2>(), Eigen::Vector2d(0.0, to_north), 0.01));
  const GeodeticDatum east{49.0, 8.401, 115.0};
  const double to_east =
      0.001 * kRadPerDeg * (east_west_radius() + 115.0) * std::cos(49.0 * kRadPerDeg);
  EXPECT_TRUE(
      near(enu_between(kDatum, east).translation.head<2>(), Eigen::Vector2d(to_east, 0.0), 0.01));
  const GeodeticDatum above{49.0, 8.4, 165.0};
  EXPECT_TRUE(
      near(enu_between(kDatum, above), {Eigen::Quaterniond::Identity(), {0.0, 0.0, 50.0}}, 1e-6));
}

// Ten kilometres further north, the vertical is tilted by the angle between the two.
TEST(EnuBetween, TurnsTheVerticalByTheCurvatureOfTheEarth) {
  const GeodeticDatum north{49.1, 8.4, 115.0};
  const Pose T = enu_between(kDatum, north);
  const Eigen::Vector3d up = T.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::acos(up.z()), 0.1 * kRadPerDeg, 1e-9);
  EXPECT_GT(up.y(), 0.0) << "it leans to the north";
  const double drop = T.translation.head<2>().squaredNorm() / (2.0 * north_south_radius());
  EXPECT_NEAR(T.translation.z(), -drop, 0.05);
}

TEST(EnuBetween, IsInvertedByTheOtherDirection) {
  const GeodeticDatum other{48.7, 9.1, 300.0};
  EXPECT_TRUE(
      near(enu_between(kDatum, other) * enu_between(other, kDatum), Pose::Identity(), 1e-6));
}

GnssPosition position() {
  GnssPosition result;
  result.p_enu_antenna = {10.0, 0.0, 3.0};
  result.covariance = Eigen::Vector3d(4.0, 1.0, 9.0).asDiagonal();
  result.R_enu_base = exp_so3({0.0, 0.0, 0.2});
  return result;
}

TEST(TransformedPosition, TakesCovarianceAndHeadingAlong) {
  const Pose quarter_turn{exp_so3({0.0, 0.0, kPi / 2.0}), {100.0, 200.0, 5.0}};
  const GnssPosition moved = transformed_position(position(), quarter_turn);
  EXPECT_TRUE(near(moved.p_enu_antenna, Eigen::Vector3d(100.0, 210.0, 8.0), 1e-9));
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1.0, 4.0, 9.0).asDiagonal();
  EXPECT_TRUE(near(moved.covariance, covariance, 1e-9)) << "east and north change places";
  EXPECT_NEAR(yaw_of(*moved.R_enu_base), 0.2 + kPi / 2.0, 1e-9);
}

// A height of which nothing is known (10 km) would otherwise be metres of error in the plane.
TEST(TransformedPosition, KeepsAnUnknownHeightOutOfThePlane) {
  GnssPosition level = position();
  level.covariance(2, 2) = kUnknownHeightStddev * kUnknownHeightStddev;
  level.R_enu_base.reset();
  const Pose tilt{exp_so3({0.002, 0.0, 0.0}), {0.0, 0.0, 0.0}};
  const GnssPosition moved = transformed_position(level, tilt);
  EXPECT_NEAR(moved.covariance(1, 1), 1.0, 1e-3);
  EXPECT_FALSE(has_height(moved.covariance));
  EXPECT_FALSE(moved.R_enu_base);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
