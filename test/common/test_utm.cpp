// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/utm.hpp"

#include "near.hpp"

namespace lidar_mapping {
namespace {

TEST(UtmFrame, ConvertsToEastingsAndNorthingsAndBack) {
  const UtmFrame utm({49.0, 9.0, 110.0});  // on the central meridian of zone 32
  EXPECT_EQ(utm.epsg(), 32632);
  EXPECT_NEAR(utm.origin().x(), 500'000.0, 1e-6);
  EXPECT_EQ(utm.origin().z(), 110.0);
  const Eigen::Vector3d p_enu(1234.5, -678.9, 12.3);
  EXPECT_TRUE(test::near(utm.to_enu(utm.from_enu(p_enu)), p_enu, 1e-6));
  const Eigen::Vector3d east = utm.from_enu({100.0, 0.0, 0.0}) - utm.origin();
  // The scale on the central meridian is 0.9996, at the height of the ellipsoid.
  EXPECT_NEAR(east.x(), 99.96 * (1.0 - 110.0 / 6.38e6), 1e-4);
  EXPECT_THROW(utm.to_enu({1e9, 1e9, 0.0}), InputError);
}

/// A step of ten thousand kilometres in mid-map would tear it.
TEST(UtmFrame, IsContinuousAcrossTheEquator) {
  for (const double latitude : {1e-4, -1e-4}) {
    const UtmFrame utm({latitude, 9.0, 0.0});
    const double step = utm.from_enu({0.0, 50.0, 0.0}).y() - utm.from_enu({0.0, -50.0, 0.0}).y();
    EXPECT_NEAR(step, 100.0, 0.1) << latitude;
    const Eigen::Vector3d beyond(3.0, latitude > 0.0 ? -500.0 : 500.0, 1.0);
    EXPECT_TRUE(test::near(utm.to_enu(utm.from_enu(beyond)), beyond, 1e-6)) << latitude;
  }
  EXPECT_EQ(UtmFrame({-1.0, 9.0, 0.0}).epsg(), 32732);
}

TEST(UtmFrame, KnowsThePoles) {
  EXPECT_EQ(UtmFrame({89.0, 0.0, 0.0}).epsg(), 32661);
  EXPECT_EQ(UtmFrame({-89.0, 0.0, 0.0}).epsg(), 32761);
}

}  // namespace
}  // namespace lidar_mapping
