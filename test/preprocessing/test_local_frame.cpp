// SPDX-License-Identifier: BSD-3-Clause
#include <limits>

#include <GeographicLib/Geocentric.hpp>
#include <gtest/gtest.h>

#include "gnss/local_frame.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;
using test::fix;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(LocalFrame, PointsEastNorthAndUp) {
  LocalFrame frame({});
  EXPECT_FALSE(frame.datum());
  EXPECT_TRUE(test::near(frame.to_local(fix(at(0.0))).p_enu, Eigen::Vector3d::Zero(), 1e-9));
  // Lengths of a degree at latitude 49 on WGS 84: 111 211 m north, 73 172 m east.
  EXPECT_NEAR(frame.to_local(fix(at(0.1), 49.001)).p_enu.y(), 111.21, 0.02);
  EXPECT_NEAR(frame.to_local(fix(at(0.2), 49.0, 8.401)).p_enu.x(), 73.17, 0.02);
  EXPECT_NEAR(frame.to_local(fix(at(0.3), 49.0, 8.4, 125.0)).p_enu.z(), 10.0, 1e-6);
}

TEST(LocalFrame, PreservesDistances) {
  LocalFrame frame({});
  frame.to_local(fix(at(0.0)));
  const GeographicLib::Geocentric earth = GeographicLib::Geocentric::WGS84();
  const auto ecef = [&](const GnssFix& f) {
    Eigen::Vector3d p;
    earth.Forward(f.latitude_deg, f.longitude_deg, f.altitude_m, p.x(), p.y(), p.z());
    return p;
  };
  const GnssFix a = fix(at(1.0), 49.02, 8.37, 140.0), b = fix(at(2.0), 48.98, 8.45, 90.0);
  EXPECT_NEAR((frame.to_local(a).p_enu - frame.to_local(b).p_enu).norm(),
              (ecef(a) - ecef(b)).norm(), 1e-6);
}

TEST(LocalFrame, UsesTheConfiguredDatum) {
  PreprocessingConfig config;
  config.use_datum = true;
  config.datum = {49.0, 8.4, 100.0};
  LocalFrame frame(config);
  ASSERT_TRUE(frame.datum());
  EXPECT_EQ(frame.datum()->latitude_deg, 49.0);
  EXPECT_NEAR(frame.to_local(fix(at(0.0))).p_enu.z(), 15.0, 1e-6);
}

TEST(LocalFrame, BoundsCovariancesAndFillsUnknownOnes) {
  LocalFrame frame({});
  GnssFix bad = fix(at(0.0));
  bad.covariance = 1e-10 * Eigen::Matrix3d::Identity();
  EXPECT_NEAR(frame.to_local(bad).covariance(0, 0), 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(frame.to_local(bad).covariance(2, 2), 0.1 * 0.1, 1e-12);
  for (const double value : {0.0, -1.0, kNaN}) {
    bad.covariance = value * Eigen::Matrix3d::Identity();
    EXPECT_NEAR(frame.to_local(bad).covariance(0, 0), 9.0, 1e-12) << value;
  }
  bad.covariance.reset();
  EXPECT_NEAR(frame.to_local(bad).covariance(2, 2), 36.0, 1e-12);
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(0, 1) = indefinite(1, 0) = 5.0;
  bad.covariance = indefinite;
  EXPECT_EQ(frame.to_local(bad).covariance(0, 1), 0.0);
}

/// Nothing downstream may meet a NaN, and nothing may believe the height.
TEST(LocalFrame, PutsAFixWithoutAltitudeAtTheHeightOfTheDatumWithoutWeight) {
  LocalFrame frame({});
  frame.to_local(fix(at(0.0)));
  const LocalFix known = frame.to_local(fix(at(1.0), 49.001, 8.4, 125.0));
  const LocalFix level = frame.to_local(fix(at(2.0), 49.001, 8.4, kNaN));
  EXPECT_NEAR(level.p_enu.y(), 111.21, 0.02);
  EXPECT_NEAR(level.p_enu.z(), 0.0, 0.01);
  EXPECT_FALSE(has_height(level.covariance));
  EXPECT_TRUE(has_height(known.covariance));
  EXPECT_EQ(level.covariance(0, 0), known.covariance(0, 0));
  EXPECT_EQ(step_between(known, level).z(), 0.0);
  EXPECT_NEAR(step_between(frame.to_local(fix(at(0.0))), known).z(), 10.0, 0.01);
  EXPECT_FALSE(has_height(interpolated(known, level, at(1.01)).covariance));
  EXPECT_TRUE(interpolated(known, level, at(1.5)).p_enu.allFinite());
}

TEST(LocalFrame, BeginsOnTheEllipsoidIfTheFirstFixHasNoAltitude) {
  LocalFrame frame({});
  frame.to_local(fix(at(0.0), 49.0, 8.4, kNaN));
  ASSERT_TRUE(frame.datum());
  EXPECT_EQ(frame.datum()->altitude_m, 0.0);
  EXPECT_NEAR(frame.to_local(fix(at(1.0))).p_enu.z(), 115.0, 1e-6);
}

TEST(LocalFrame, ReportsTheProblemOfAFix) {
  const PreprocessingConfig config;
  EXPECT_EQ(problem_of(fix(at(0.0)), config), "");
  const auto refuses = [&](auto&& spoil) {
    GnssFix f = fix(at(0.0));
    spoil(f);
    EXPECT_NE(problem_of(f, config), "");
  };
  EXPECT_EQ(problem_of(fix(at(0.0), 49.0, 8.4, kNaN), config), "") << "its altitude is unknown";
  refuses([](GnssFix& f) { f.status = -1; });
  refuses([](GnssFix& f) { f.latitude_deg = kNaN; });
  refuses([](GnssFix& f) { f.altitude_m = std::numeric_limits<double>::infinity(); });
  refuses([](GnssFix& f) { f.latitude_deg = f.longitude_deg = 0.0; });
  refuses([](GnssFix& f) { f.latitude_deg = 91.0; });
  refuses([](GnssFix& f) { f.altitude_m = 1e6; });
  refuses([](GnssFix& f) { f.covariance = 400.0 * Eigen::Matrix3d::Identity(); });
  PreprocessingConfig rtk;
  rtk.gnss_min_status = 2;
  GnssFix plain = fix(at(0.0));
  plain.status = 0;
  EXPECT_NE(problem_of(plain, rtk), "");
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
