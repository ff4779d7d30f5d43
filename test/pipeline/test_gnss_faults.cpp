// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "gnss_drive.hpp"

namespace lidar_mapping::test {
namespace {

/// Odometry of a good front end: noise of 1 mm and 0.05 mrad for each key frame, and a bias that
/// bends the path by 0.03 degrees in 100 m and makes it 0.02 % too long.
DriveOdometry drifting_odometry(const simulation::Drive& drive) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto random3 = [&](double sigma) {
    const double x = normal(engine), y = normal(engine), z = normal(engine);
    return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
  };
  DriveOdometry odometry;
  Pose T_odom_base, T_map_last;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Stamp stamp = drive.scan_stamp(i);
    const Pose T_map_base = drive.trajectory().pose(stamp);
    KeyFrame key_frame;
    if (i > 0) {
      Pose step = T_map_last.inverse() * T_map_base;
      const double distance = step.translation.norm();
      if (distance < 2.0) continue;
      step.translation = 1.0002 * step.translation + random3(0.001);
      step.rotation =
          step.rotation * exp_so3(Eigen::Vector3d(0, 0, 5e-6 * distance) + random3(5e-5));
      T_odom_base = T_odom_base * step;
      key_frame.index = odometry.key_frames.back().index + 1;
    }
    key_frame.stamp = stamp;
    key_frame.T_odom_base = T_odom_base;
    key_frame.motion_covariance = diagonal_covariance(0.01, 5e-4);
    odometry.key_frames.push_back(key_frame);
    T_map_last = T_map_base;
  }
  return odometry;
}

/// A few loops where the path passes the same location again.
std::vector<Loop> true_loops(const simulation::Drive& drive,
                             const std::vector<KeyFrame>& key_frames) {
  std::vector<Loop> loops;
  const auto pose = [&](const KeyFrame& key_frame) {
    return drive.trajectory().pose(key_frame.stamp);
  };
  for (std::size_t to = 0; to < key_frames.size(); to += 5) {
    for (std::size_t from = 0; from + 60 < to; ++from) {
      const Pose T_from_to = pose(key_frames[from]).inverse() * pose(key_frames[to]);
      if (T_from_to.translation.norm() > 2.0) continue;
      Loop loop;
      loop.from = key_frames[from].index;
      loop.to = key_frames[to].index;
      loop.stamp = key_frames[to].stamp;
      loop.T_from_to = T_from_to;
      loop.covariance = diagonal_covariance(0.03, 0.002);
      loop.overlap = 0.9;
      loops.push_back(loop);
      break;
    }
  }
  return loops;
}

/// Smaller errors are not due to GNSS; half the noise of the points is 1 cm.
constexpr double kTolerance = 0.005;  // m

/// As GeoPoint's NaN of hdl_graph_slam: positions east and north hold the map, and nothing draws it
/// to the height that stands for an unknown one. Every fifth fix has an altitude in the second run.
TEST(GnssFaults, FixesWithoutAltitudeConstrainTheMapEastAndNorth) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  const simulation::Drive drive(options);
  const DriveOdometry odometry = drifting_odometry(drive);
  const double without = final_error(drive, odometry, std::nullopt);
  const double with_height = final_error(drive, odometry, receiver_of(drive));
  for (const std::size_t known_every : {std::size_t{0}, std::size_t{5}}) {
    Receiver level = receiver_of(drive);
    for (std::size_t i = 0; i < level.fixes.size(); ++i) {
      if (known_every == 0 || i % known_every != 0) level.fixes[i].altitude_m = std::nan("");
    }
    const auto scans = preprocessed_scans(drive, level, {});
    std::size_t positions = 0;
    for (const auto& scan : scans) {
      if (!scan.gnss) continue;
      ++positions;
      EXPECT_TRUE(scan.gnss->p_enu_antenna.allFinite() && scan.gnss->covariance.allFinite());
    }
    EXPECT_GT(positions, 9 * scans.size() / 10) << known_every;
    const double error = final_error(drive, odometry, level);
    EXPECT_LT(error, 0.5 * without) << known_every << ": " << with_height << " with heights";
  }
}

TEST(GnssFaults, FinalErrorIsHardlyAffected) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  const simulation::Drive drive(options);
  DriveOdometry odometry = drifting_odometry(drive);
  odometry.loops = true_loops(drive, odometry.key_frames);
  const Receiver rtk = receiver_of(drive);
  const Receiver single = noisy_receiver(drive, 1.0);
  const double without = final_error(drive, odometry, std::nullopt);
  const double clean_rtk = final_error(drive, odometry, rtk);
  const double clean_single = final_error(drive, odometry, single);
  std::printf("without %.4f rtk %.4f single %.4f\n", without, clean_rtk, clean_single);
  for (const GnssFault& fault : gnss_faults(drive, rtk, single)) {
    const double clean = fault.clean == &rtk ? clean_rtk : clean_single;
    const double error = final_error(drive, odometry, fault.faulty);
    std::printf("%-40s %.4f %.2f\n", fault.name.c_str(), error, error / clean);
    EXPECT_LE(error, 1.3 * clean + kTolerance) << fault.name;
    EXPECT_LE(error, std::max(without, clean) + kTolerance) << fault.name;
  }
}

/// Poses with errors of 2 mm and 0.1 mrad, as with 64 beams in a town: fixes with a standard
/// deviation of 2 cm can add little.
TEST(GnssFaults, GoodOdometrySmoothsTheNoiseOfFixes) {
  simulation::DriveOptions options;
  options.lidar = "hdl64";
  const simulation::Drive drive(options);
  DriveOdometry odometry = drifting_odometry(drive);
  std::mt19937 engine(4);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (KeyFrame& key_frame : odometry.key_frames) {
    const auto random3 = [&](double sigma) {
      const double x = normal(engine), y = normal(engine), z = normal(engine);
      return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
    };
    key_frame.T_odom_base = drive.trajectory().pose(key_frame.stamp);
    key_frame.T_odom_base.translation += random3(0.002);
    key_frame.T_odom_base.rotation = key_frame.T_odom_base.rotation * exp_so3(random3(1e-4));
  }
  EXPECT_LE(final_error(drive, odometry, receiver_of(drive)), 0.008);
}

}  // namespace
}  // namespace lidar_mapping::test
