// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

namespace lidar_mapping::simulation {
namespace {

constexpr std::size_t kInACurve = 95;

DriveOptions small_options() {
  DriveOptions options;
  options.lidar = "vlp16";
  options.range_noise = 0.0;
  return options;
}

const Drive& small_drive() {
  static const Drive drive(small_options());
  return drive;
}

bool same(const SimulatedScan& a, const SimulatedScan& b) {
  const auto equal = [](const Point& p, const Point& q) {
    return p.x == q.x && p.y == q.y && p.z == q.z && p.intensity == q.intensity;
  };
  return a.stamp == b.stamp && a.cloud.times == b.cloud.times && a.moving == b.moving &&
         std::equal(a.cloud.points.begin(), a.cloud.points.end(), b.cloud.points.begin(),
                    b.cloud.points.end(), equal);
}

/// Distance of each point behind (positive) or before the surface along its beam, m. The times of
/// the points give the poses of the LiDAR.
std::vector<double> surface_errors(const Drive& drive, const SimulatedScan& scan) {
  static const RayCaster caster(small_drive().world());  // the same world for the same seed
  std::vector<Ray> rays;
  std::vector<double> ranges;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    if (scan.moving[i] != 0) continue;
    const Stamp when =
        scan.stamp + (scan.cloud.has_times() ? from_seconds(scan.cloud.times[i]) : 0);
    const Pose T_map_lidar = drive.trajectory().pose(when) * drive.mounting().T_base_lidar;
    const Eigen::Vector3d p_map = T_map_lidar * scan.cloud.points[i].position().cast<double>();
    const Eigen::Vector3d beam = p_map - T_map_lidar.translation;
    // Only the last metre before the surface, so that moving objects elsewhere do not matter.
    const Eigen::Vector3d origin = p_map - beam.normalized();
    rays.push_back({origin.cast<float>(), beam.normalized().cast<float>(), 0.0F});
  }
  std::vector<Hit> hits;
  caster.cast(rays, 1e6, 1e6 + 1.0, 0.0F, 5.0F, hits);
  std::vector<double> errors;
  for (const Hit& hit : hits) errors.push_back(hit.range < 0.0F ? 5.0 : 1.0 - hit.range);
  return errors;
}

double fraction_within(const std::vector<double>& errors, double limit) {
  const auto inside =
      std::count_if(errors.begin(), errors.end(), [&](double e) { return std::abs(e) < limit; });
  return static_cast<double>(inside) / static_cast<double>(errors.size());
}

TEST(Scan, UndistortedScanLiesOnSurfaces) {
  DriveOptions options = small_options();
  options.undistorted = true;
  const Drive drive(options);
  const SimulatedScan scan = drive.scan(kInACurve);
  ASSERT_GT(scan.cloud.size(), 15000U);
  EXPECT_FALSE(scan.cloud.has_times());
  // A grazing beam may miss an edge because of rounding.
  EXPECT_GT(fraction_within(surface_errors(drive, scan), 2e-3), 0.999);
}

TEST(Scan, DeskewedScanLiesOnSurfaces) {
  const Drive& drive = small_drive();
  EXPECT_GT(fraction_within(surface_errors(drive, drive.scan(kInACurve)), 2e-3), 0.999);
}

TEST(Scan, ScanIsDistortedByMotion) {
  const Drive& drive = small_drive();
  SimulatedScan scan = drive.scan(kInACurve);
  scan.cloud.times.clear();
  EXPECT_LT(fraction_within(surface_errors(drive, scan), 0.02), 0.7);
}

TEST(Scan, HasGivenRangeNoise) {
  DriveOptions options = small_options();
  options.range_noise = 0.03;
  const Drive drive(options);
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const double error : surface_errors(drive, drive.scan(3))) {
    if (std::abs(error) > 0.2) continue;  // beside an edge
    sum += error;
    squares += error * error;
    ++count;
  }
  EXPECT_NEAR(sum / count, 0.0, 0.002);
  EXPECT_NEAR(std::sqrt(squares / count), 0.03, 0.002);
}

TEST(Scan, DependsOnSeedAndNotOnThreads) {
  DriveOptions options = small_options();
  options.range_noise = 0.02;
  const Drive first(options), second(options);
  std::vector<SimulatedScan> alone(4), together(4);
  for (std::size_t i = 0; i < 4; ++i) alone[i] = first.scan(i);
  parallel_chunks(4, 1, 4, [&](std::size_t i, std::size_t) { together[i] = second.scan(i); });
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(same(alone[i], together[i])) << "scan " << i;
  options.seed = 2;
  EXPECT_FALSE(same(alone[0], Drive(options).scan(0)));
}

TEST(Scan, HasTimesOfItsColumns) {
  const Drive& drive = small_drive();
  const SimulatedScan scan = drive.scan(7);
  ASSERT_EQ(scan.cloud.times.size(), scan.cloud.size());
  EXPECT_TRUE(std::is_sorted(scan.cloud.times.begin(), scan.cloud.times.end()));
  EXPECT_GE(scan.cloud.times.front(), 0.0F);
  EXPECT_LT(scan.cloud.times.back(), 0.1F);
  EXPECT_EQ(scan.end - scan.stamp, 100'000'000);
  EXPECT_EQ(drive.scan_stamp(8), scan.end);
}

TEST(Scan, ContainsMoversOnlyIfEnabled) {
  const Drive& busy = small_drive();
  DriveOptions options = small_options();
  options.movers = false;
  const Drive quiet(options);
  const auto moving = [](const SimulatedScan& scan) {
    return std::count(scan.moving.begin(), scan.moving.end(), 1);
  };
  EXPECT_GT(moving(busy.scan(50)), 20);
  EXPECT_EQ(moving(quiet.scan(50)), 0);
}

TEST(Scan, BeamsHaveElevationsOfTheModel) {
  const Drive& drive = small_drive();
  const SimulatedScan scan = drive.scan(0);
  for (const Point& p : scan.cloud.points) {
    const double elevation = std::atan2(p.z, std::hypot(p.x, p.y)) * kDegPerRad;
    const double beam = std::round((elevation + 15.0) / 2.0) * 2.0 - 15.0;
    ASSERT_NEAR(elevation, beam, 1e-3);
  }
}

TEST(DriveOptions, OutOfRangeAreRejected) {
  const std::vector<std::function<void(DriveOptions&)>> mistakes = {
      [](DriveOptions& options) { options.drive = "moon"; },
      [](DriveOptions& options) { options.scan_rate = 0.0; },
      [](DriveOptions& options) { options.duration = 0.0; },
      [](DriveOptions& options) { options.start = -1.0; },
      [](DriveOptions& options) { options.start = 1e10; },
      [](DriveOptions& options) { options.start = std::nan(""); },
      [](DriveOptions& options) { options.pass = 1'000'000; },
      [](DriveOptions& options) { options.rounds = 0; },
      [](DriveOptions& options) { options.range_noise = -0.1; }};
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    DriveOptions options = small_options();
    mistakes[i](options);
    EXPECT_THROW(Drive{options}, ConfigError) << i;
  }
}

// 1e300 s are more than a stamp can hold.
TEST(DriveOptions, OfALongDurationLastUntilTheEndOfTheDrive) {
  DriveOptions options = small_options();
  options.drive = "tunnel";
  const std::size_t all = Drive(options).scan_count();
  options.duration = 1e300;
  EXPECT_EQ(Drive(options).scan_count(), all);
}

}  // namespace
}  // namespace lidar_mapping::simulation
