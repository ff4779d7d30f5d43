// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"

namespace lidar_mapping::simulation {
namespace {

double degrees(double rad) { return rad * kDegPerRad; }

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

TEST(LidarModel, HasNameAndDirectionOfEachRay) {
  for (const std::string& name : lidar_names()) {
    const LidarModel model = lidar_model(name);
    EXPECT_EQ(model.name, name);
    const auto directions = ray_directions(model, 3);
    ASSERT_EQ(directions.size(), model.ray_count());
    for (const Eigen::Vector3d& d : directions) ASSERT_NEAR(d.norm(), 1.0, 1e-12) << name;
  }
}

/// Azimuth and elevation in degrees.
struct Direction {
  double azimuth, elevation;
};

std::vector<Direction> directions_of(const std::string& name, std::size_t frame) {
  std::vector<Direction> result;
  for (const Eigen::Vector3d& d : ray_directions(lidar_model(name), frame)) {
    result.push_back({degrees(std::atan2(d.y(), d.x())), degrees(std::asin(d.z()))});
  }
  return result;
}

struct Field {
  double left = -1e9, right = 1e9, top = -1e9, bottom = 1e9;
};

Field field_of(const std::string& name, std::size_t frames) {
  Field field;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    for (const Direction& direction : directions_of(name, frame)) {
      field.left = std::max(field.left, direction.azimuth);
      field.right = std::min(field.right, direction.azimuth);
      field.top = std::max(field.top, direction.elevation);
      field.bottom = std::min(field.bottom, direction.elevation);
    }
  }
  return field;
}

/// Fraction of the cells of one degree between these elevations that are hit in some frames.
double covered_fraction(const std::string& name, std::size_t frames, int bottom, int top,
                        int half) {
  std::set<std::pair<int, int>> covered;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    for (const Direction& direction : directions_of(name, frame)) {
      const std::pair<int, int> cell(static_cast<int>(std::floor(direction.azimuth)),
                                     static_cast<int>(std::floor(direction.elevation)));
      const bool is_inside =
          cell.first >= -half && cell.first < half && cell.second >= bottom && cell.second < top;
      if (is_inside) covered.insert(cell);
    }
  }
  return static_cast<double>(covered.size()) / (2.0 * half * (top - bottom));
}

TEST(LidarModel, HasFieldOfViewOfItsSensor) {
  const Field os0 = field_of("os0", 1);
  EXPECT_NEAR(os0.top - os0.bottom, 90.0, 1e-6);
  const Field mid360 = field_of("mid360", 2);
  EXPECT_NEAR(mid360.bottom, -7.0, 0.2);
  EXPECT_NEAR(mid360.top, 52.0, 0.2);
  EXPECT_NEAR(mid360.left - mid360.right, 360.0, 1.0);
  const Field avia = field_of("avia", 20);
  EXPECT_NEAR(avia.left - avia.right, 70.4, 1.0);
  EXPECT_NEAR(avia.top - avia.bottom, 77.2, 1.0);
  const Field rs_m1 = field_of("rs_m1", 1);
  EXPECT_NEAR(rs_m1.left - rs_m1.right, 120.0, 0.3);
  EXPECT_NEAR(rs_m1.top - rs_m1.bottom, 25.0, 0.3);
}

TEST(LidarModel, NonRepetitivePatternsFillTheirField) {
  EXPECT_LT(covered_fraction("mid360", 1, -7, 52, 180), 0.8);
  EXPECT_GT(covered_fraction("mid360", 10, -7, 52, 180), 0.99);
  EXPECT_LT(covered_fraction("avia", 1, -20, 20, 20), 0.98);
  EXPECT_GT(covered_fraction("avia", 10, -20, 20, 20), 0.99);
  for (const char* name : {"mid360", "avia"}) {
    EXPECT_NE(ray_directions(lidar_model(name), 0), ray_directions(lidar_model(name), 1));
    EXPECT_EQ(ray_directions(lidar_model(name), 7), ray_directions(lidar_model(name), 7));
  }
  EXPECT_EQ(ray_directions(lidar_model("rs_m1"), 0), ray_directions(lidar_model("rs_m1"), 1));
}

TEST(LidarModel, HasRaysPerFrameOfItsSensor) {
  EXPECT_EQ(lidar_model("mid360").ray_count(), 20'000U);
  EXPECT_EQ(lidar_model("avia").ray_count(), 24'000U);
  EXPECT_EQ(lidar_model("rs_m1").ray_count(), 75'000U);
}

TEST(LidarModel, RejectsUnknownName) { EXPECT_THROW(lidar_model("hdl65"), ConfigError); }

}  // namespace
}  // namespace lidar_mapping::simulation
