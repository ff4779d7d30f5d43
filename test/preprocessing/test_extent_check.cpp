// SPDX-License-Identifier: BSD-3-Clause
// Clouds in another unit than metres, or in another frame than the sensor's.

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "checks/input_checks.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

/// A ring of 10 m around the sensor, scaled and then moved.
PointCloud ring(float scale, const Eigen::Vector3f& moved = Eigen::Vector3f::Zero()) {
  PointCloud cloud = test::ring_scan(0).cloud;
  for (Point& point : cloud.points) {
    const Eigen::Vector3f p = scale * point.position() + moved;
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
  }
  return cloud;
}

std::string findings(const PointCloud& cloud) {
  InputReport report{"points", "", {}};
  if (const auto extent = extent_of(cloud)) check_extent(*extent, report);
  std::string text;
  for (const CheckDiagnostic& diagnostic : report.diagnostics) text += sentence(diagnostic) + "\n";
  return text;
}

TEST(ExtentCheck, MeasuresTheMiddleAndTheRadius) {
  PointCloud cloud = ring(1.0F, {5.0F, -3.0F, 1.0F});
  const auto extent = extent_of(cloud);
  ASSERT_TRUE(extent.has_value());
  EXPECT_TRUE(test::near(extent->middle, Eigen::Vector3f(5.0F, -3.0F, 1.0F), 0.5));
  EXPECT_NEAR(extent->radius, 10.0F, 0.5F);
}

TEST(ExtentCheck, LeavesOutPointsThatAreNone) {
  PointCloud cloud;
  cloud.points.assign(10, Point{});
  EXPECT_FALSE(extent_of(cloud).has_value()) << "all at the origin";
  for (Point& point : cloud.points) point.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(extent_of(cloud).has_value()) << "none is finite";
}

TEST(ExtentCheck, FindsNothingInMetres) {
  EXPECT_EQ(findings(ring(0.1F)), "");
  EXPECT_EQ(findings(ring(5.0F)), "");
  EXPECT_EQ(findings(ring(2.0F, {40.0F, 0.0F, 0.0F})), "") << "a sensor that looks ahead";
  EXPECT_EQ(findings(ring(6.0F, {0.0F, 0.0F, -110.0F})), "") << "a drone";
}

TEST(ExtentCheck, FindsOtherUnits) {
  const std::string millimetres = findings(ring(1000.0F));
  EXPECT_NE(millimetres.find("in millimetres"), std::string::npos) << millimetres;
  const std::string centimetres = findings(ring(100.0F));
  EXPECT_NE(centimetres.find("in centimetres"), std::string::npos) << centimetres;
  EXPECT_NE(centimetres.find("metres (REP 103)"), std::string::npos) << centimetres;
}

TEST(ExtentCheck, FindsCloudsInAFrameOfTheWorld) {
  const std::string local = findings(ring(2.0F, {188.0F, 143.0F, 2.0F}));
  EXPECT_NE(local.find("around (18"), std::string::npos) << local;
  EXPECT_NE(local.find("in a frame of the world: record"), std::string::npos) << local;
  const std::string utm = findings(ring(2.0F, {455000.0F, 5429000.0F, 115.0F}));
  EXPECT_NE(utm.find("in a frame of the world"), std::string::npos) << utm;
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
