// SPDX-License-Identifier: BSD-3-Clause
// A sensor whose elevations are all off by the same angle is found out from the drive itself.

#include <gtest/gtest.h>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/front_end/front_end.hpp"

#include "evaluated_drive.hpp"
#include "local_map/elevation_calibration.hpp"
#include "motion/motion_filter.hpp"
#include "scan/sweep_sampler.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Of a sensor with many beams, which see much from one place to the next.
simulation::Drive town(double duration) { return make_drive("town", duration, 3, "hdl64"); }

/// In base_link, of a sensor that reports all elevations too low by `angle`.
Scan lowered_scan(const simulation::Drive& drive, std::size_t index, double angle) {
  simulation::SimulatedScan scan = drive.scan(index);
  rotate_upwards(scan.cloud, -angle);
  return {scan.stamp, transformed(scan.cloud, drive.mounting().T_base_lidar)};
}

double mean_elevation(const PointCloud& cloud) {
  double sum = 0.0;
  for (const Point& p : cloud.points) sum += std::atan2(p.z, std::hypot(p.x, p.y));
  return sum / static_cast<double>(cloud.size());
}

}  // namespace

TEST(ElevationMean, ContainsTheScatterOfItsEstimates) {
  ElevationMean mean;
  EXPECT_EQ(mean.value().angle, 0.0);
  for (const double angle : {0.01, 0.03, 0.01, 0.03}) mean.add({angle, 1e-4});
  EXPECT_NEAR(mean.value().angle, 0.02, 1e-12);
  EXPECT_NEAR(mean.value().sigma, 0.01 / std::sqrt(4.0), 1e-6);
}

TEST(ElevationMean, WeightsEstimatesByTheirSigma) {
  ElevationMean mean;
  mean.add({0.0, 0.1});
  mean.add({0.01, 0.001});
  EXPECT_NEAR(mean.value().angle, 0.01, 1e-4);
}

/// Every third scan from `first` on, put into the map at its true pose; thinned out to a point per
/// `cube` (m) if that is not 0.
ElevationCalibration calibrate(const simulation::Drive& drive, std::size_t first, double angle,
                               bool between_scans = false, double cube = 0.0) {
  SweepSampler sampler{FrontEndConfig{}};
  ElevationCalibration calibration;
  for (std::size_t i = first; i < drive.scan_count(); i += 3) {
    Scan scan = lowered_scan(drive, i, angle);
    if (cube > 0.0) scan.cloud = voxel_filtered(scan.cloud, cube);
    sampler.set_elevation_shift(calibration.applied_angle());
    sampler.sample(scan, i);
    const double middle = to_seconds(scan.stamp) + sampler.reference();
    const Pose T_map_base = drive.trajectory().pose(from_seconds(middle));
    const Pose soon = drive.trajectory().pose(from_seconds(middle + 0.02));
    calibration.add_scan(sampler.sample_dense(scan),
                         {T_map_base, twist_between(T_map_base, soon, 0.02)}, 1.0);
    if (between_scans) calibration.compare_pending();
  }
  return calibration;
}

class ElevationCalibrationTest : public testing::TestWithParam<double> {};

TEST_P(ElevationCalibrationTest, FindsTheAngleFromScansAtKnownPoses) {
  const double angle = GetParam() * kRadPerDeg;
  const ElevationCalibration calibration = calibrate(town(22.0), 20, angle);
  const ElevationEstimate accepted_angle = calibration.estimate();
  EXPECT_LT(accepted_angle.sigma, 0.04 * kRadPerDeg)
      << "0.6 of that of a pair, 0.03, and their scatter";
  EXPECT_NEAR(accepted_angle.angle, angle, 3.0 * accepted_angle.sigma);
  // Nothing is corrected that is right, and most of what is wrong.
  EXPECT_NEAR(calibration.accepted_angle(), angle, angle == 0.0 ? 0.0 : 0.05 * kRadPerDeg);
}

INSTANTIATE_TEST_SUITE_P(Degrees, ElevationCalibrationTest, testing::Values(0.0, -0.2));

TEST(ElevationCalibration, GivesTheSameResultWhenComparingBetweenScans) {
  const simulation::Drive drive = town(14.0);
  const ElevationCalibration within = calibrate(drive, 20, 0.0);
  ElevationCalibration between = calibrate(drive, 20, 0.0, true);
  between.compare_pending();
  ElevationCalibration late = within;
  late.compare_pending();
  EXPECT_NE(between.estimate().sigma, 0.0);
  EXPECT_EQ(late.estimate().angle, between.estimate().angle);
  EXPECT_EQ(late.estimate().sigma, between.estimate().sigma);
}

TEST(ElevationCalibration, IgnoresScansThatDoNotDetermineTheirRelativePose) {
  constexpr std::size_t kInside = 250;  // from here on the tube is nearly all that is in sight
  const ElevationCalibration calibration = calibrate(make_drive("tunnel", 33.0, 3), kInside, 0.0);
  // Its pairs would seem to give 0.037 degrees to within 0.013.
  EXPECT_GT(calibration.estimate().sigma, 0.03 * kRadPerDeg);
  EXPECT_EQ(calibration.accepted_angle(), 0.0);
}

// Pairs of one place can agree on an angle that is not there: -0.11 degrees in this town, 3.5
// standard deviations of their scatter.
TEST(ElevationCalibration, ExpectsACommonErrorOfAPlace) {
  const ElevationCalibration calibration = calibrate(make_drive("town", 60.0, 65), 0, 0.0);
  EXPECT_LT(calibration.estimate().angle, -0.1 * kRadPerDeg);
  EXPECT_GT(calibration.estimate().angle, -2.0 * calibration.estimate().sigma);
  EXPECT_EQ(calibration.accepted_angle(), 0.0);
}

// A voxel of the map holds few points of such a cloud: planes through four of them would hide half
// of the angle.
TEST(ElevationCalibration, FindsTheAngleInCloudsThatWereThinnedOut) {
  const double angle = -0.2 * kRadPerDeg;
  const ElevationCalibration calibration = calibrate(town(22.0), 20, angle, false, 0.5);
  EXPECT_LT(calibration.estimate().sigma, 0.04 * kRadPerDeg);
  EXPECT_NEAR(calibration.accepted_angle(), angle, 0.03 * kRadPerDeg);
}

TEST(FrontEnd, RotatesThePointsOfASensorWithWrongElevations) {
  const double angle = 0.3 * kRadPerDeg;
  const simulation::Drive drive = town(20.0);
  FrontEndConfig config;
  config.key_frame_cloud_resolution = 0.0;
  FrontEnd front_end(config);
  config.calibrate_elevation = false;
  FrontEnd plain(config);
  double shift = 0.0;
  double last_rise = 0.0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Scan scan = lowered_scan(drive, i, angle);
    const FrontEndResult turned = front_end.process(scan);
    const FrontEndResult untouched = plain.process(scan);
    EXPECT_EQ(untouched.status.elevation_shift, 0.0);
    shift = turned.status.elevation_shift;
    if (!turned.key_frame || !untouched.key_frame) continue;
    const double rise =
        mean_elevation(*turned.key_frame->cloud) - mean_elevation(*untouched.key_frame->cloud);
    // Not at once: the map that the scan is matched with has still the fault.
    EXPECT_NEAR(rise, last_rise, 0.12 * kRadPerDeg);
    last_rise = rise;
  }
  EXPECT_NEAR(last_rise, shift, 0.03 * kRadPerDeg);
  EXPECT_NEAR(shift, angle, 0.1 * kRadPerDeg);
}

}  // namespace lidar_mapping::front_end
