#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"

namespace lidar_mapping::simulation {
namespace {

double degrees(double rad) { return rad * 180.0 / M_PI; }

TEST(LidarModel, HasTheBeamsOfItsSensor) {
  const LidarModel hdl64 = lidar_model("hdl64");
  ASSERT_EQ(hdl64.elevations.size(), 64U);
  EXPECT_NEAR(degrees(hdl64.elevations.front()), 2.0, 1e-9);
  EXPECT_NEAR(degrees(hdl64.elevations.back()), -24.8, 1e-9);
  const LidarModel vlp16 = lidar_model("vlp16");
  ASSERT_EQ(vlp16.elevations.size(), 16U);
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(degrees(vlp16.elevations[i]), 15.0 - 2.0 * i, 1e-9);
  const LidarModel os1_64 = lidar_model("os1_64");
  ASSERT_EQ(os1_64.elevations.size(), 64U);
  EXPECT_NEAR(degrees(os1_64.elevations.front()), 22.5, 1e-9);
  EXPECT_NEAR(degrees(os1_64.elevations.back()), -22.5, 1e-9);
}

TEST(LidarModel, TurnsClockwiseFromBehind) {
  const LidarModel model = lidar_model("hdl64");
  EXPECT_NEAR(column_azimuth(model, 0), M_PI, 1e-12);
  EXPECT_NEAR(column_azimuth(model, model.columns / 4), M_PI_2, 1e-12);
  EXPECT_NEAR(column_azimuth(model, model.columns / 2), 0.0, 1e-12);
}

TEST(LidarModel, RefusesAnUnknownName) { EXPECT_THROW(lidar_model("hdl65"), ConfigError); }

}  // namespace
}  // namespace lidar_mapping::simulation
