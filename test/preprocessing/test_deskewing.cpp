// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "recorded_scans.hpp"
#include "samples.hpp"
#include "test_data.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;
using test::identity_lookup;

/// A motion in a plane with a wobble in yaw: pose of base_link in a fixed frame.
struct Motion {
  double speed = 10.0;
  double yaw_rate = 0.3;
  double wobble = 0.0;     ///< rad
  double frequency = 2.0;  ///< Hz

  double rate(double t) const {
    return yaw_rate + wobble * 2.0 * M_PI * frequency * std::cos(2.0 * M_PI * frequency * t);
  }
  double yaw(double t) const {
    return yaw_rate * t + wobble * std::sin(2.0 * M_PI * frequency * t);
  }
  Pose pose(double t) const {
    Pose pose;
    const int steps = 2000;
    for (int i = 0; i < steps; ++i) {
      const double middle = yaw(t * (i + 0.5) / steps);
      pose.translation +=
          speed * t / steps * Eigen::Vector3d(std::cos(middle), std::sin(middle), 0.0);
    }
    pose.rotation = exp_so3({0.0, 0.0, yaw(t)});
    return pose;
  }
};

/// A turn of a sensor at `T_base_lidar` that meets, at each azimuth, a landmark of a fixed circle.
RawScan scan_in_motion(const Motion& motion, double stamp, double begin, double direction,
                       double start_azimuth, const Pose& T_base_lidar) {
  RawScan scan;
  scan.stamp = at(stamp);
  scan.frame_id = "lidar";
  for (int i = 0; i < 200; ++i) {
    const double t = begin + 0.1 * i / 200.0;
    const double azimuth = start_azimuth + direction * 2.0 * M_PI * i / 200.0;
    const Eigen::Vector3d landmark(30.0 * std::cos(azimuth), 30.0 * std::sin(azimuth), 1.0);
    const Pose T_fixed_lidar = motion.pose(stamp + t) * T_base_lidar;
    const Eigen::Vector3f p =
        (T_fixed_lidar.inverse() * (motion.pose(stamp) * landmark)).cast<float>();
    scan.cloud.points.push_back({p.x(), p.y(), p.z(), static_cast<float>(azimuth)});
    scan.cloud.times.push_back(static_cast<float>(t));
  }
  scan.times_are_absolute = true;
  return scan;
}

/// Largest distance of the points from their landmarks as seen at the stamp.
double residual(const PointCloud& cloud) {
  double largest = 0.0;
  for (const Point& p : cloud.points) {
    const Eigen::Vector3d landmark(30.0 * std::cos(p.intensity), 30.0 * std::sin(p.intensity), 1.0);
    largest = std::max(largest, (p.position().cast<double>() - landmark).norm());
  }
  return largest;
}

struct Rig {
  Motion motion;
  bool imu = true;
  bool gyro = true;
  bool velocity = true;
  bool velocity_turns = true;
  double begin = -0.05;
  double direction = -1.0;
  double start_azimuth = 0.0;
  Pose T_base_lidar;
  Pose T_base_imu;
};

/// With the points in base_link.
SyncedScan deskewed(const Rig& rig) {
  const double stamp = 1.0;
  Preprocessor stage({}, [&](const std::string& frame) -> std::optional<Pose> {
    return frame == "lidar" ? rig.T_base_lidar : rig.T_base_imu;
  });
  const Eigen::Quaterniond to_imu = rig.T_base_imu.rotation.conjugate();
  for (int i = 50; i < 150; ++i) {
    const double t = 0.01 * i;
    const Eigen::Vector3d omega(0.0, 0.0, rig.motion.rate(t));
    const Eigen::Vector3d v =
        Eigen::Vector3d(rig.motion.speed, 0.0, 0.0) + omega.cross(rig.T_base_imu.translation);
    ImuSample sample = test::imu(at(t), rig.gyro ? to_imu * omega : Eigen::Vector3d::Zero());
    sample.has_angular_velocity = rig.gyro;
    if (rig.imu) stage.add_imu(sample, "imu");
    if (rig.velocity) {
      const Eigen::Vector3d turning =
          rig.velocity_turns ? (to_imu * omega).eval() : Eigen::Vector3d::Zero().eval();
      stage.add_velocity(test::velocity(at(t), to_imu * v, turning), "imu");
    }
  }
  auto scans = stage.process(scan_in_motion(rig.motion, stamp, rig.begin, rig.direction,
                                            rig.start_azimuth, rig.T_base_lidar));
  test::append(scans, stage.flush());
  EXPECT_EQ(scans.size(), 1U);
  SyncedScan& scan = scans.front();
  scan.scan.cloud = transformed(scan.scan.cloud, scan.T_base_lidar);
  return scan;
}

TEST(Deskewing, IsExactForEveryStartAndDirection) {
  for (const double direction : {-1.0, 1.0}) {
    for (const double start : {0.0, 0.5, M_PI / 2, M_PI, 4.7}) {
      for (const double begin : {0.0, -0.05, -0.1}) {
        Rig rig;
        rig.direction = direction;
        rig.start_azimuth = start;
        rig.begin = begin;
        const SyncedScan scan = deskewed(rig);
        EXPECT_FALSE(scan.scan.cloud.has_times());
        EXPECT_EQ(scan.scan.cloud.size(), 200U);
        EXPECT_LT(residual(scan.scan.cloud), 0.001);
      }
    }
  }
}

TEST(Deskewing, HandlesRotatedAndDistantSensors) {
  std::mt19937 engine(4);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto vector = [&] {
    return Eigen::Vector3d(normal(engine), normal(engine), normal(engine));
  };
  for (int i = 0; i < 20; ++i) {
    Rig rig;
    rig.T_base_lidar = {exp_so3(vector()), vector()};
    rig.T_base_imu = {exp_so3(vector()), vector()};
    EXPECT_LT(residual(deskewed(rig).scan.cloud), 0.001);
    rig.velocity_turns = false;  // the lever arm of the velocity by the gyro
    EXPECT_LT(residual(deskewed(rig).scan.cloud), 0.001);
  }
}

TEST(Deskewing, HandlesNonUniformRotation) {
  Rig rig;
  rig.motion.wobble = 0.05;
  Rig without = rig;
  without.imu = without.velocity = false;
  const double raw = residual(deskewed(without).scan.cloud);
  EXPECT_LT(residual(deskewed(rig).scan.cloud), 0.02 * raw);
}

TEST(Deskewing, WorksWithVelocityAlone) {
  Rig rig;
  rig.imu = false;
  const SyncedScan scan = deskewed(rig);
  EXPECT_FALSE(scan.scan.cloud.has_times());
  EXPECT_LT(residual(scan.scan.cloud), 0.001);
}

/// An IMU may give an attitude alone: that it does not turn must not be concluded.
TEST(Deskewing, UsesNoRotationFromAnImuWithoutGyro) {
  Rig rig;
  rig.gyro = false;
  EXPECT_LT(residual(deskewed(rig).scan.cloud), 0.001) << "the velocity turns";
}

TEST(Deskewing, KeepsTimesIfDeskewingIsImpossible) {
  Rig nothing;
  nothing.imu = nothing.velocity = false;
  Rig speed_alone;
  speed_alone.imu = false;
  speed_alone.velocity_turns = false;
  for (const Rig& rig : {nothing, speed_alone}) {
    const SyncedScan scan = deskewed(rig);
    ASSERT_EQ(scan.scan.cloud.times.size(), 200U);
    EXPECT_NEAR(scan.scan.cloud.times.front(), -0.05, 1e-6);
  }
}

TEST(Deskewing, WithTheGyroAloneLeavesAUniformRotation) {
  Rig rig;
  rig.velocity = false;
  rig.motion.speed = 0.0;
  rig.motion.wobble = 0.05;
  const SyncedScan scan = deskewed(rig);
  const PointCloud& cloud = scan.scan.cloud;
  ASSERT_TRUE(cloud.has_times());
  ASSERT_TRUE(scan.imu);
  // Whoever takes the turning as uniform at the rate that is handed on gets the scan right.
  PointCloud compensated = cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = (exp_so3(scan.imu->angular_velocity * cloud.times[i]) *
                               cloud.points[i].position().cast<double>())
                                  .cast<float>();
    compensated.points[i] = {p.x(), p.y(), p.z(), cloud.points[i].intensity};
  }
  EXPECT_LT(residual(compensated), 0.005);
}

// The front end undoes the correction where it finds the gyro wrong.
TEST(Deskewing, TheGyrosCorrectionCanBeUndone) {
  Rig rig;
  rig.velocity = false;
  rig.motion.speed = 0.0;
  rig.motion.wobble = 0.05;
  rig.T_base_lidar = {exp_so3({0.1, 0.2, -0.3}), {0.5, -0.2, 1.0}};
  // Turnings are about the LiDAR, in the axes of base_link.
  const Pose to_lidar{Eigen::Quaterniond::Identity(), -rig.T_base_lidar.translation};
  SyncedScan scan = deskewed(rig);
  scan.scan.cloud = transformed(scan.scan.cloud, to_lidar);
  rig.imu = false;
  SyncedScan raw = deskewed(rig);
  raw.scan.cloud = transformed(raw.scan.cloud, to_lidar);
  ASSERT_TRUE(scan.uneven_turning);
  EXPECT_FALSE(raw.uneven_turning);
  double bent = 0.0, left = 0.0;
  const PointCloud again = put_back(*scan.uneven_turning, scan.scan.cloud);
  for (std::size_t i = 0; i < raw.scan.cloud.size(); ++i) {
    const Eigen::Vector3f seen = raw.scan.cloud.points[i].position();
    bent = std::max<double>(bent, (scan.scan.cloud.points[i].position() - seen).norm());
    left = std::max<double>(left, (again.points[i].position() - seen).norm());
  }
  EXPECT_GT(bent, 0.02);
  EXPECT_LT(left, 1e-4);
}

TEST(Deskewing, CorrectsASimulatedDrive) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  options.duration = 30.0;
  const simulation::Drive drive(options);
  Preprocessor stage({}, [&](const std::string& frame) -> std::optional<Pose> {
    return frame == "lidar" ? drive.mounting().T_base_lidar : drive.mounting().T_base_imu;
  });
  for (const ImuSample& sample : drive.imu()) stage.add_imu(sample, "imu");
  for (const VelocitySample& sample : drive.velocity()) stage.add_velocity(sample, "imu");
  double squares = 0.0, squares_raw = 0.0;
  std::size_t count = 0;
  for (std::size_t index = 150; index < 290; index += 20) {
    const simulation::SimulatedScan scan = drive.scan(index);
    RawScan raw{scan.stamp, "lidar", scan.cloud};
    std::vector<SyncedScan> out = stage.process(raw);
    test::append(out, stage.flush());
    ASSERT_EQ(out.size(), 1U);
    const PointCloud cloud = transformed(out[0].scan.cloud, drive.mounting().T_base_lidar);
    ASSERT_FALSE(cloud.has_times());
    const Pose T_stamp = drive.trajectory().pose(scan.stamp).inverse();
    std::size_t j = 0;
    for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
      const Eigen::Vector3d p = scan.cloud.points[i].position().cast<double>();
      if (p.norm() < 1.0 || p.norm() > 200.0) continue;
      const Stamp time = scan.stamp + from_seconds(scan.cloud.times[i]);
      const Eigen::Vector3d truth =
          T_stamp * (drive.trajectory().pose(time) * (drive.mounting().T_base_lidar * p));
      squares += (cloud.points[j].position().cast<double>() - truth).squaredNorm();
      squares_raw += (drive.mounting().T_base_lidar * p - truth).squaredNorm();
      ++j;
      ++count;
    }
    ASSERT_EQ(j, cloud.size());
  }
  const double rms = std::sqrt(squares / static_cast<double>(count));
  EXPECT_LT(rms, 0.01) << "raw " << std::sqrt(squares_raw / static_cast<double>(count));
}

double mean_distance(const PointCloud& a, const PointCloud& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a.points[i].position() - b.points[i].position()).norm();
  }
  return sum / static_cast<double>(a.size());
}

/// The benchmark's own compensated copy of a raw scan, by times from the azimuth.
TEST(Deskewing, AgreesWithTheCompensatedScansOfKitti) {
  REQUIRE_RECORDED(raw_folder, "kitti00_scans");
  REQUIRE_RECORDED(done_folder, "kitti00_compensated");
  PreprocessingConfig config;
  config.point_times = PointTimes::kAzimuth;
  config.scan_stamp = ScanStamp::kMiddle;
  config.scan_period = 0.104;
  config.use_distance_filter = false;
  // Motion at the two scans, from the notes of the recording.
  const double speeds[] = {7.5, 4.5};
  const double yaw_rates[] = {0.0, -14.0 * kRadPerDeg};
  const std::size_t raws[] = {0, 37};
  for (std::size_t i = 0; i < 2; ++i) {
    const PointCloud raw = lidar_mapping::test::recorded_scan(raw_folder, raws[i]);
    const PointCloud done = lidar_mapping::test::recorded_scan(done_folder, i);
    ASSERT_EQ(raw.size(), done.size());
    Preprocessor stage(config, identity_lookup);
    for (int k = -20; k < 20; ++k) {
      stage.add_velocity(test::velocity(at(0.01 * k), {speeds[i], 0.0, 0.0},
                                        {0.0, 0.0, yaw_rates[i] == 0.0 ? 1e-9 : yaw_rates[i]}),
                         "lidar");
    }
    auto scans = stage.process({at(0.0), "lidar", raw});
    test::append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 1U);
    ASSERT_EQ(scans[0].scan.cloud.size(), raw.size());
    EXPECT_LT(mean_distance(scans[0].scan.cloud, done), 0.4 * mean_distance(raw, done));
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
