// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {
namespace {

constexpr std::size_t kScan = 25;

Drive drive_with(const std::vector<std::string>& faults) {
  DriveOptions options;
  options.drive = "tunnel";
  options.lidar = "vlp16";
  options.duration = 8.0;
  for (const std::string& fault : faults) options.scan_faults.push_back(parse_scan_fault(fault));
  return Drive(options);
}

const Drive& clean_drive() {
  static const Drive drive = drive_with({});
  return drive;
}

std::set<std::tuple<float, float, float>> positions(const SimulatedScan& scan) {
  std::set<std::tuple<float, float, float>> result;
  for (const Point& p : scan.cloud.points) result.insert({p.x, p.y, p.z});
  return result;
}

/// Points of `scan` that the clean scan does not have.
std::vector<Point> added(const SimulatedScan& scan) {
  const auto clean = positions(clean_drive().scan(kScan));
  std::vector<Point> result;
  for (const Point& p : scan.cloud.points) {
    if (clean.count({p.x, p.y, p.z}) == 0) result.push_back(p);
  }
  return result;
}

double added_fraction(const SimulatedScan& scan) {
  return static_cast<double>(added(scan).size()) / static_cast<double>(scan.cloud.size());
}

TEST(ScanFaults, OutliersHaveGivenFractionAndFillTheView) {
  const SimulatedScan scan = drive_with({"outliers=0.2"}).scan(kScan);
  EXPECT_NEAR(added_fraction(scan), 0.2, 0.01);
  int far = 0, left = 0, above = 0;
  for (const Point& p : added(scan)) {
    far += p.position().norm() > 50.0F ? 1 : 0;
    left += p.y > 0.0F ? 1 : 0;
    above += p.z > 0.0F ? 1 : 0;
  }
  const double all = static_cast<double>(added(scan).size());
  EXPECT_NEAR(far / all, 0.5, 0.05);
  EXPECT_NEAR(left / all, 0.5, 0.05);
  EXPECT_NEAR(above / all, 0.5, 0.05);
}

TEST(ScanFaults, ArtificialPointsHaveOrderAndTimesOfTheSweep) {
  const SimulatedScan scan = drive_with({"outliers=0.2", "rain=0.1", "wall"}).scan(kScan);
  ASSERT_EQ(scan.cloud.times.size(), scan.cloud.size());
  ASSERT_EQ(scan.moving.size(), scan.cloud.size());
  EXPECT_TRUE(std::is_sorted(scan.cloud.times.begin(), scan.cloud.times.end()));
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Point& p = scan.cloud.points[i];
    const double azimuth = M_PI - 2.0 * M_PI * scan.cloud.times[i] / 0.1;
    ASSERT_LT(std::abs(std::remainder(std::atan2(p.y, p.x) - azimuth, 2.0 * M_PI)), 1e-3) << i;
  }
}

TEST(ScanFaults, RainEndsRaysNearTheSensor) {
  const SimulatedScan scan = drive_with({"rain=0.3"}).scan(kScan);
  const std::vector<Point> drops = added(scan);
  for (const Point& p : drops) ASSERT_LT(p.position().norm(), 8.01F);
  EXPECT_GT(added_fraction(scan), 0.15);
  EXPECT_LT(added_fraction(scan), 0.45);
}

TEST(ScanFaults, WallFillsLeftHalfAndMovesAlong) {
  const Drive drive = drive_with({"wall"});
  const std::size_t before = added(drive.scan(kScan)).size();
  EXPECT_GT(before, 4000U);
  for (const std::size_t index : {kScan, kScan + 40}) {
    std::size_t points_on_wall = 0;
    for (const Point& p : drive.scan(index).cloud.points) {
      points_on_wall += std::abs(p.y - 2.5F) < 0.3F && std::abs(p.x) < 9.0F ? 1 : 0;
    }
    EXPECT_GT(points_on_wall, 4000U) << index;
  }
}

TEST(ScanFaults, JitterChangesStampsOnly) {
  const Drive drive = drive_with({"jitter=0.02"});
  double sum = 0.0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const double error = to_seconds(drive.reported_stamp(i) - drive.scan_stamp(i));
    EXPECT_LE(std::abs(error), 0.045);
    EXPECT_TRUE(i == 0 || drive.reported_stamp(i) > drive.reported_stamp(i - 1)) << i;
    sum += error * error;
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(drive.scan_count())), 0.02, 0.005);
  const SimulatedScan scan = drive.scan(kScan);
  EXPECT_EQ(scan.stamp, drive.reported_stamp(kScan));
  EXPECT_EQ(positions(scan), positions(clean_drive().scan(kScan)));
}

TEST(ScanFaults, FrozenScansAreRepeated) {
  const Drive drive = drive_with({"frozen=3,2"});
  for (const std::size_t first : {20, 40}) {
    for (std::size_t i = first + 1; i <= first + 3; ++i) {
      EXPECT_EQ(positions(drive.scan(i)), positions(drive.scan(first))) << i;
      EXPECT_EQ(drive.scan(i).stamp, drive.scan_stamp(i));
    }
    EXPECT_NE(positions(drive.scan(first + 4)), positions(drive.scan(first)));
  }
  EXPECT_NE(positions(drive.scan(1)), positions(drive.scan(0))) << "a drive begins well";
}

TEST(ScanFaults, SparseScanIsSubsetOfAllDirections) {
  const SimulatedScan scan = drive_with({"sparse=500"}).scan(kScan);
  EXPECT_EQ(scan.cloud.size(), 500U);
  EXPECT_EQ(scan.cloud.times.size(), 500U);
  EXPECT_TRUE(added(scan).empty());
  EXPECT_LT(scan.cloud.times.front(), 0.005F);
  EXPECT_GT(scan.cloud.times.back(), 0.095F);
}

TEST(ScanFaults, PointTimesAreMissingOrNegated) {
  const SimulatedScan clean = clean_drive().scan(kScan);
  const SimulatedScan none = drive_with({"times=none"}).scan(kScan);
  EXPECT_FALSE(none.cloud.has_times());
  EXPECT_EQ(positions(none), positions(clean));
  const SimulatedScan negated = drive_with({"times=negated"}).scan(kScan);
  ASSERT_EQ(negated.cloud.times.size(), clean.cloud.times.size());
  for (std::size_t i = 0; i < clean.cloud.times.size(); ++i) {
    ASSERT_EQ(negated.cloud.times[i], -clean.cloud.times[i]);
  }
}

class EverySensor : public testing::TestWithParam<std::string> {};

TEST_P(EverySensor, HasWallAndOutliersAlongItsOwnRays) {
  DriveOptions options;
  options.drive = "tunnel";
  options.lidar = GetParam();
  options.duration = 2.0;
  options.scan_faults = {parse_scan_fault("outliers=0.2"), parse_scan_fault("wall")};
  const Drive drive(options);
  const SimulatedScan scan = drive.scan(5);
  const auto directions = ray_directions(drive.lidar(), 5);
  ASSERT_EQ(scan.rays.size(), scan.cloud.size());
  std::size_t points_on_wall = 0;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Eigen::Vector3d p = scan.cloud.points[i].position().cast<double>();
    ASSERT_LT(p.normalized().cross(directions[scan.rays[i]]).norm(), 1e-5) << i;
    points_on_wall += std::abs(p.y() - 2.5) < 0.3 && std::abs(p.x()) < 9.0 ? 1 : 0;
  }
  EXPECT_GT(points_on_wall, scan.cloud.size() / 20);
}

INSTANTIATE_TEST_SUITE_P(Sensors, EverySensor, testing::ValuesIn(lidar_names()),
                         [](const auto& lidar) { return lidar.param; });

TEST(ScanFaults, RejectInvalidTexts) {
  for (const char* text :
       {"fog=0.1", "outliers", "outliers=", "outliers=1.5", "rain=nan", "wall=2", "jitter=0.01,2",
        "frozen=0", "frozen=3,0", "sparse=-5", "sparse=5x", "times", "times=wrong", "times=0"}) {
    EXPECT_THROW(parse_scan_fault(text), ConfigError) << text;
  }
  EXPECT_EQ(parse_scan_fault("frozen=3,10").every_s, 10.0);
  EXPECT_EQ(parse_scan_fault("frozen=3").amount, 3.0);
}

}  // namespace
}  // namespace lidar_mapping::simulation
