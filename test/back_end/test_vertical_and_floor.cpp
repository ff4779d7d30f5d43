// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "back_end_fixture.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::DriveSettings;
using test::feed;
using test::optimize;
using test::SyntheticDrive;

/// Odometry with a slow drift in roll and pitch.
SyntheticDrive tilting_drive(double slope = 0.0) {
  DriveSettings settings;
  settings.hill = 0.0;
  settings.laps = 1;
  SyntheticDrive drive = test::make_drive(settings);
  const Eigen::Quaterniond ramp = exp_so3({0.0, -std::atan(slope), 0.0});
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    drive.truth[i] = Pose{ramp, Eigen::Vector3d::Zero()} * drive.truth[i];
    if (i == 0) continue;
    Pose motion = drive.truth[i - 1].inverse() * drive.truth[i];
    motion.rotation = motion.rotation * exp_so3({0.01 * kRadPerDeg, 0.02 * kRadPerDeg, 0.0});
    drive.key_frames[i].T_odom_base = drive.key_frames[i - 1].T_odom_base * motion;
  }
  return drive;
}

double tilt_of(const Pose& estimated, const Pose& truth) {
  const Eigen::Vector3d up = estimated.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d true_up = truth.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  return std::acos(std::min(1.0, up.dot(true_up)));
}

double mean_tilt_error(const BackEnd& back_end, const SyntheticDrive& drive) {
  double sum = 0.0;
  const auto poses = back_end.poses().poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += tilt_of(poses[i].T_map_base, drive.truth[i]);
  }
  return sum / static_cast<double>(poses.size());
}

double height_error(const BackEnd& back_end, const SyntheticDrive& drive) {
  const auto poses = back_end.poses().poses;
  // Heights relative to the first pose in its own frame, independent of the pose of the map.
  double worst = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose a = poses.front().T_map_base.inverse() * poses[i].T_map_base;
    const Pose b = drive.truth.front().inverse() * drive.truth[i];
    worst = std::max(worst, std::abs(a.translation.z() - b.translation.z()));
  }
  return worst;
}

ImuSample imu_at(const SyntheticDrive& drive, std::size_t i) {
  ImuSample sample;
  sample.stamp = drive.key_frames[i].stamp;
  return sample;
}

TEST(Imu, TiltOfItsOrientationKeepsTheMapLevel) {
  // The heading of such an orientation is arbitrary.
  const SyntheticDrive drive = tilting_drive();
  BackEndConfig config;
  config.imu_orientation_stddev = 0.5 * kRadPerDeg;
  BackEnd back_end(config);
  feed(back_end, drive);
  EXPECT_GT(mean_tilt_error(back_end, drive), 1.0 * kRadPerDeg);
  std::mt19937 engine(2);
  std::normal_distribution<double> normal(0.0, 0.5 * kRadPerDeg);
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    ImuSample sample = imu_at(drive, i);
    sample.orientation = exp_so3({0.0, 0.0, 1.2}) * drive.truth[i].rotation *
                         exp_so3({normal(engine), normal(engine), normal(engine)});
    back_end.add_imu(sample);
  }
  EXPECT_TRUE(optimize(back_end).success);
  EXPECT_LT(mean_tilt_error(back_end, drive), 0.3 * kRadPerDeg);
}

TEST(Imu, ItsOrientationCanBeSwitchedOff) {
  const SyntheticDrive drive = tilting_drive();
  BackEndConfig config;
  config.enable_imu_orientation = false;
  BackEnd back_end(config);
  feed(back_end, drive);
  const double before = mean_tilt_error(back_end, drive);
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    ImuSample sample = imu_at(drive, i);
    sample.orientation = drive.truth[i].rotation;
    back_end.add_imu(sample);
  }
  optimize(back_end);
  EXPECT_NEAR(mean_tilt_error(back_end, drive), before, 0.01 * kRadPerDeg);
}

TEST(Imu, GravityMayHaveEitherSignAndTheVehicleMayBrake) {
  const SyntheticDrive drive = tilting_drive();
  for (const double sign : {1.0, -1.0}) {
    BackEndConfig config;
    config.enable_imu_acceleration = true;
    config.imu_acceleration_stddev = 0.5 * kRadPerDeg;
    BackEnd back_end(config);
    feed(back_end, drive);
    for (std::size_t i = 0; i < drive.truth.size(); ++i) {
      ImuSample sample = imu_at(drive, i);
      Eigen::Vector3d force = drive.truth[i].rotation.conjugate() * Eigen::Vector3d(0.0, 0.0, 9.81);
      if (i % 50 >= 40) force.x() -= 4.0;  // braking for 10 m of every 50
      sample.linear_acceleration = sign * force;
      back_end.add_imu(sample);
    }
    EXPECT_TRUE(optimize(back_end).success);
    EXPECT_LT(mean_tilt_error(back_end, drive), 0.2 * kRadPerDeg) << "sign " << sign;
  }
}

TEST(Imu, HeadingsWithPositionsRotateTheGraph) {
  DriveSettings settings;
  settings.turn_bias_deg = 0.05;
  const SyntheticDrive drive = test::make_drive(settings);
  const auto error_with = [&](bool headings) {
    BackEndConfig config;
    config.enable_imu_heading = headings;
    config.imu_heading_stddev = 0.5 * kRadPerDeg;
    BackEnd back_end(config);
    feed(back_end, drive);
    std::mt19937 engine(2);
    for (int i = 0; i < 800; ++i) {
      GnssPosition position = test::make_gnss(drive, i, engine, 1.0);
      position.R_enu_base = drive.truth[i].rotation;
      back_end.add_gnss(position);
    }
    optimize(back_end);
    const Pose& last = back_end.poses().poses.back().T_map_base;
    return std::abs(yaw_of(drive.truth.back().rotation.conjugate() * last.rotation));
  };
  EXPECT_LT(error_with(true), 1.0 * kRadPerDeg);
  EXPECT_LT(error_with(true), error_with(false));
}

Floor floor_at(const SyntheticDrive& drive, std::size_t i, const Eigen::Vector3d& normal,
               double height) {
  Floor floor;
  floor.stamp = drive.key_frames[i].stamp;
  floor.found = true;
  floor.normal = drive.truth[i].rotation.conjugate() * normal;
  floor.offset = height;
  floor.covariance = Eigen::Vector3d(1e-8, 1e-8, 1e-6).asDiagonal();
  return floor;
}

double height_error_with(FloorConstraint constraint, const SyntheticDrive& drive, double slope) {
  BackEndConfig config;
  config.floor_stddev_rad = 0.02 * kRadPerDeg;  // as even as the floor of a hall
  config.floor_constraint = constraint;
  BackEnd back_end(config);
  feed(back_end, drive);
  const Eigen::Vector3d normal = Eigen::Vector3d(-slope, 0.0, 1.0).normalized();
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    back_end.add_floor(floor_at(drive, i, normal, 1.8));
  }
  EXPECT_TRUE(optimize(back_end).success);
  return height_error(back_end, drive);
}

TEST(Floor, NeighboursRemoveTheDriftOfAFlatHall) {
  const SyntheticDrive drive = tilting_drive();
  const double without_floors = height_error_with(FloorConstraint::kNone, drive, 0.0);
  EXPECT_LT(height_error_with(FloorConstraint::kNeighbours, drive, 0.0), 0.7 * without_floors);
  EXPECT_LT(height_error_with(FloorConstraint::kPlane, drive, 0.0), 0.1 * without_floors);
}

TEST(Floor, ARampIsNotFlattened) {
  const SyntheticDrive drive = tilting_drive(0.08);
  const double without_floors = height_error_with(FloorConstraint::kNone, drive, 0.08);
  EXPECT_LT(height_error_with(FloorConstraint::kNeighbours, drive, 0.08), 1.01 * without_floors);
}

// Common errors of neighbouring floors, as at the beginning of a ramp, are not taken for drift of
// an accurate odometry.
TEST(Floor, NoisyFloorsHardlyDisturbGoodOdometry) {
  SyntheticDrive drive = tilting_drive();
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    drive.key_frames[i].T_odom_base = drive.truth[i];
    drive.key_frames[i].motion_covariance = diagonal_covariance(5e-4, 2e-5);
  }
  BackEndConfig config;
  config.floor_constraint = FloorConstraint::kNeighbours;
  BackEnd back_end(config);
  feed(back_end, drive);
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    const double phase = 2.0 * M_PI * static_cast<double>(i) / 60.0;
    const Eigen::Vector3d up =
        exp_so3({0.0, 1.0 * kRadPerDeg * std::sin(phase), 0.0}) * Eigen::Vector3d::UnitZ();
    Floor floor = floor_at(drive, i, up, 1.8 + 0.04 * std::cos(phase));
    floor.covariance = Eigen::Vector3d(4e-6, 4e-6, 1e-4).asDiagonal();
    back_end.add_floor(floor);
  }
  optimize(back_end, true);
  EXPECT_LT(test::aligned_rmse(back_end, drive), 0.0095);
}

// Two storeys with different floors, connected by a ramp.
TEST(Floor, TwoStoreysAreKeptApart) {
  DriveSettings settings;
  settings.hill = 3.0;
  const SyntheticDrive drive = test::make_drive(settings);
  const auto error_with = [&](FloorConstraint constraint) {
    BackEndConfig config;
    config.floor_constraint = constraint;
    BackEnd back_end(config);
    feed(back_end, drive);
    for (std::size_t i = 0; i < drive.truth.size(); ++i) {
      const std::size_t ahead = std::min(i + 1, drive.truth.size() - 1);
      const std::size_t behind = std::max<std::size_t>(i, 1) - 1;
      const Eigen::Vector3d along =
          (drive.truth[ahead].translation - drive.truth[behind].translation).normalized();
      const Eigen::Vector3d normal = Eigen::Vector3d::UnitZ() - along.z() * along;
      back_end.add_floor(floor_at(drive, i, normal.normalized(), 1.8));
    }
    optimize(back_end);
    return height_error(back_end, drive);
  };
  EXPECT_LT(error_with(FloorConstraint::kNeighbours),
            1.1 * error_with(FloorConstraint::kNone) + 0.05);
}

TEST(Floor, FloorsThatWereNotFoundAreIgnored) {
  const SyntheticDrive drive = tilting_drive();
  BackEndConfig config;
  config.floor_constraint = FloorConstraint::kPlane;
  BackEnd back_end(config);
  feed(back_end, drive);
  Floor floor = floor_at(drive, 0, Eigen::Vector3d::UnitZ(), 1.8);
  floor.found = false;
  back_end.add_floor(floor);
  optimize(back_end);
  EXPECT_TRUE(test::near(back_end.poses().poses.back().T_map_base.translation,
                         drive.key_frames.back().T_odom_base.translation, 1e-6));
}

}  // namespace
}  // namespace lidar_mapping::back_end
