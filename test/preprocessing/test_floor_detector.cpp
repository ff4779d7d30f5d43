// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/preprocessing/floor_detector.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

namespace lidar_mapping::preprocessing {
namespace {

/// Range along a ray, m; empty if it meets nothing.
using RangeOf = std::function<std::optional<double>(const Eigen::Vector3d& ray)>;

/// What beams from 15 degrees below the horizon on, 2 degrees apart, see from `height` above the
/// origin.
Scan scan_of(int beams, double height, std::uint32_t seed, const RangeOf& range_of) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> noise(0.0, 0.02);
  Scan scan;
  for (int beam = 0; beam < beams; ++beam) {
    const double elevation = (-15.0 + 2.0 * beam) * kRadPerDeg;
    for (int step = 0; step < 900; ++step) {
      const double azimuth = 2.0 * M_PI * step / 900;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const auto range = range_of(ray);
      if (!range) continue;
      const Eigen::Vector3f p =
          (Eigen::Vector3d(0.0, 0.0, height) + (*range + noise(engine)) * ray).cast<float>();
      scan.cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
    }
  }
  return scan;
}

/// What 16 beams at `height` see of a plane through the point below them, and of a wall around.
Scan scan_of_plane(const Eigen::Vector3d& normal, double height, std::uint32_t seed) {
  return scan_of(16, 0.0, seed, [&](const Eigen::Vector3d& ray) {
    const double down = -normal.dot(ray), wall = 12.0 / ray.head<2>().norm();
    return down > 1e-3 ? std::min(normal.z() * height / down, wall) : wall;
  });
}

/// What 8 beams 1.8 m above the origin see of a road whose height depends on x alone.
Scan scan_of_road(const std::function<double(double)>& road, std::uint32_t seed) {
  constexpr double kHeight = 1.8;
  return scan_of(8, kHeight, seed, [&](const Eigen::Vector3d& ray) -> std::optional<double> {
    double near = 0.0, far = 60.0;
    for (int halving = 0; halving < 40; ++halving) {
      const double range = 0.5 * (near + far);
      (kHeight + range * ray.z() > road(range * ray.x()) ? near : far) = range;
    }
    if (far == 60.0) return std::nullopt;
    return near;
  });
}

FloorDetectionConfig config_for(double height) {
  FloorDetectionConfig config;
  config.sensor_height = height;
  return config;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(FloorDetector, FindsTiltedFloors) {
  for (const double lean : {0.0, 3.0, -4.0}) {
    const Eigen::Vector3d normal(std::sin(lean * kRadPerDeg), 0.0, std::cos(lean * kRadPerDeg));
    const Scan scan = scan_of_plane(normal, 1.8, 7);
    const Floor floor = FloorDetector(config_for(1.8)).process(scan);
    ASSERT_TRUE(floor.found);
    EXPECT_LT(angle_between(floor.normal, normal), 0.2 * kRadPerDeg);
    EXPECT_NEAR(floor.offset, 1.8 * normal.z(), 0.02);
    EXPECT_TRUE(floor.covariance.llt().info() == Eigen::Success);
  }
}

/// A sensor that is tilted by 20 degrees, above level ground.
struct TiltedSensor {
  FloorDetectionConfig config = config_for(1.8);
  Eigen::Quaterniond R_level_base = exp_so3(Eigen::Vector3d(0.0, 20.0 * kRadPerDeg, 0.0));
  Scan scan = scan_of_plane(Eigen::Vector3d::UnitZ(), 1.8, 8);

  TiltedSensor() {
    config.tilt = 20.0 * kRadPerDeg;
    scan.cloud = transformed(scan.cloud, Pose{R_level_base.conjugate(), Eigen::Vector3d::Zero()});
  }
};

TEST(FloorDetector, CompensatesTheTiltOfTheSensor) {
  const TiltedSensor tilted;
  EXPECT_FALSE(FloorDetector(config_for(1.8)).process(tilted.scan).found);
  const Floor floor = FloorDetector(tilted.config).process(tilted.scan);
  ASSERT_TRUE(floor.found);
  EXPECT_LT(angle_between(tilted.R_level_base * floor.normal, Eigen::Vector3d::UnitZ()),
            0.2 * kRadPerDeg);
}

TEST(FloorDetector, ReturnsThePointsItSearchedAndFound) {
  const TiltedSensor tilted;
  FloorPoints points;
  const Floor floor = FloorDetector(tilted.config).process(tilted.scan, &points);
  ASSERT_TRUE(floor.found);
  EXPECT_EQ(points.inliers.size(), static_cast<std::size_t>(floor.inliers));
  EXPECT_GE(points.filtered.size(), points.inliers.size());
  for (const Point& p : points.inliers.points) {  // in base_link, as the plane is
    EXPECT_NEAR(floor.normal.dot(p.position().cast<double>()) + floor.offset, 0.0, 0.15);
  }
  FloorDetector(tilted.config).process({}, &points);
  EXPECT_TRUE(points.filtered.empty());
  EXPECT_TRUE(points.inliers.empty());
}

TEST(FloorDetector, SearchesOnlyNearTheExpectedFloor) {  // Heights from base_link
  const Scan scan = scan_of_plane(Eigen::Vector3d::UnitZ(), 1.8, 9);
  EXPECT_FALSE(FloorDetector(config_for(0.0)).process(scan).found);
  EXPECT_TRUE(FloorDetector(config_for(1.3)).process(scan).found);
}

TEST(FloorDetector, RejectsWallsAndEmptyScans) {
  EXPECT_FALSE(FloorDetector({}).process({}).found);
  Scan walls = scan_of_plane(Eigen::Vector3d::UnitZ(), 100.0, 10);
  EXPECT_FALSE(FloorDetector(config_for(1.0)).process(walls).found);
  EXPECT_FALSE(FloorDetector(config_for(0.0)).process(walls).found);
}

TEST(FloorDetector, RejectsTooFewPointsAndSteepPlanes) {
  const Eigen::Vector3d steep(std::sin(15.0 * kRadPerDeg), 0.0, std::cos(15.0 * kRadPerDeg));
  EXPECT_FALSE(FloorDetector(config_for(1.8)).process(scan_of_plane(steep, 1.8, 11)).found);
  FloorDetectionConfig many = config_for(1.8);
  many.floor_pts_thresh = 100000;
  EXPECT_FALSE(FloorDetector(many).process(scan_of_plane(Eigen::Vector3d::UnitZ(), 1.8, 12)).found);
}

/// A bank of 35 degrees begins 6 m ahead. It lies in the heights that are searched, so that only
/// its slope tells it from the floor.
TEST(FloorDetector, LeavesOutPlacesThatAreNotLevelIfTold) {
  const auto bank = [](double x) { return 0.7 * std::max(0.0, x - 6.0); };
  const Scan scan = scan_of_road(bank, 16);
  const auto points_on_bank = [&](bool use_normal_filtering, double degrees) {
    FloorDetectionConfig config;
    config.use_normal_filtering = use_normal_filtering;
    config.normal_filter_thresh = degrees * kRadPerDeg;
    FloorPoints points;
    FloorDetector(config).process(scan, &points);
    return std::count_if(points.filtered.points.begin(), points.filtered.points.end(),
                         [](const Point& p) { return p.x > 6.0F && p.z > 0.15F; });
  };
  EXPECT_GT(points_on_bank(false, 20.0), 100);
  EXPECT_LT(5 * points_on_bank(true, 20.0), points_on_bank(false, 20.0))
      << "all but lines of points, whose slope nobody knows";
  EXPECT_EQ(points_on_bank(true, 60.0), points_on_bank(false, 20.0));
}

TEST(FloorDetector, MeasuresTheHeightOnCrestsAndInDips) {
  for (const double radius : {600.0, -600.0, 1500.0}) {
    const Scan scan = scan_of_road([&](double x) { return 0.01 * x - x * x / (2.0 * radius); }, 13);
    const Floor floor = FloorDetector({}).process(scan);
    ASSERT_TRUE(floor.found) << radius;
    EXPECT_NEAR(floor.offset, 0.0, 0.01) << radius;
    EXPECT_LT(angle_between(floor.normal, {-0.01, 0.0, 1.0}), 0.1 * kRadPerDeg) << radius;
  }
}

TEST(FloorDetector, StaysOnTheRoadBetweenPavements) {
  const auto pavements = [](double x) { return std::abs(x) > 12.0 ? 0.12 : 0.0; };
  const Floor floor = FloorDetector({}).process(scan_of_road(pavements, 14));
  ASSERT_TRUE(floor.found);
  EXPECT_NEAR(floor.offset, 0.0, 0.02);
}

TEST(FloorDetector, RejectsTheFootOfARamp) {
  const auto foot = [](double x) { return 0.115 * std::max(0.0, x - 3.0); };
  EXPECT_FALSE(FloorDetector({}).process(scan_of_road(foot, 15)).found);
}

/// The street within two metres of the vehicle as (rotation about x, about y, height) of a plane
/// z = height + rx y - ry x in base_link, by rays straight down.
Eigen::Vector3d street_below(const simulation::RayCaster& caster, const Pose& T_map_base,
                             double seconds) {
  std::vector<simulation::Ray> rays;
  std::vector<Eigen::Vector3d> origins;
  for (double x = -2.0; x <= 2.0; x += 0.5) {
    for (double y = -1.0; y <= 1.0; y += 0.5)
      origins.push_back(T_map_base * Eigen::Vector3d(x, y, 0.4));
  }
  for (const Eigen::Vector3d& origin : origins) {
    simulation::Ray ray;
    ray.origin = origin.cast<float>();
    ray.direction = -Eigen::Vector3f::UnitZ();
    rays.push_back(ray);
  }
  std::vector<simulation::Hit> hits;
  caster.cast(rays, seconds, seconds, 0.01F, 5.0F, hits);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d p =
        T_map_base.inverse() * (origins[i] - Eigen::Vector3d(0, 0, hits[i].range));
    const Eigen::Vector3d row(p.y(), -p.x(), 1.0);
    normal += row * row.transpose();
    right += row * p.z();
  }
  return normal.llt().solve(right);
}

/// Every so many scans of the town drive.
void expect_street(const std::string& lidar, std::uint64_t seed, std::size_t every) {
  simulation::DriveOptions options;
  options.lidar = lidar;
  options.seed = seed;
  const simulation::Drive drive(options);
  const simulation::RayCaster caster(drive.world());
  const FloorDetector detector({});
  int good = 0;
  int all = 0;
  for (std::size_t i = 0; i < drive.scan_count(); i += every) {
    const Scan scan = drive.base_scan(i);
    const Floor floor = detector.process(scan);
    const Eigen::Vector3d truth = street_below(caster, drive.trajectory().pose(scan.stamp),
                                               to_seconds(scan.stamp - drive.trajectory().begin()));
    const Eigen::Vector3d normal = Eigen::Vector3d(truth.y(), -truth.x(), 1.0).normalized();
    const double lean = angle_between(floor.normal, normal);
    ++all;
    if (floor.found && lean < 0.5 * kRadPerDeg && std::abs(floor.offset + truth.z()) < 0.03) ++good;
  }
  EXPECT_GE(good, 0.99 * all) << lidar << " " << seed;
}

TEST(FloorDetector, FindsTheStreetBelowASimulatedDrive) {
  expect_street("vlp16", 1, 40);
  expect_street("vlp16", 10, 40);  // stands and turns on the hilltops of this town
  expect_street("os1_64", 1, 120);
  expect_street("hdl64", 1, 160);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
