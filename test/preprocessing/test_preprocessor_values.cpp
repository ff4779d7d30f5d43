// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "near.hpp"
#include "straight_drive.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using lidar_mapping::test::near;
using test::append;
using test::at;
using test::drive;
using test::fix;
using test::identity_lookup;
using test::imu;
using test::kNothingMissing;
using test::ring_scan;
using test::velocity;

TEST(Preprocessor, DoesNotUseAGyroWithImpossibleRates) {
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 300; ++i) {
    const double degrees_per_s = i < 150 ? 1.0 : 20.0;  // where rad/s are expected
    const bool shock = i >= 50 && i < 55;
    stage.add_imu(imu(at(0.01 * i), {0.0, 0.0, shock ? 30.0 : degrees_per_s}), "imu");
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(0.01 * i))));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 30U);
  EXPECT_TRUE(scans[12].imu->has_angular_velocity);  // a shock is none
  EXPECT_FALSE(scans[20].imu->has_angular_velocity);
  EXPECT_NE(test::messages_of(stage).find("imu_angular_unit"), std::string::npos);
}

// Turns of 5 degrees/s look like 5 rad/s: no vehicle's limit tells, but the velocity does.
TEST(Preprocessor, DoesNotUseAGyroThatContradictsTheVelocity) {
  for (const double unit : {1.0, 180.0 / M_PI}) {
    Preprocessor stage({}, identity_lookup);
    std::vector<SyncedScan> scans;
    for (int i = 0; i < 300; ++i) {
      const double turning = i < 100 ? 0.0 : 0.09;  // rad/s
      stage.add_imu(imu(at(0.01 * i), {0.5 * std::sin(0.1 * i), 0.0, unit * turning}), "imu");
      stage.add_velocity({at(0.01 * i), {8.0, 0.0, 0.0}, {0.0, 0.0, turning}}, "imu");
      if (i % 10 == 5) append(scans, stage.process(ring_scan(at(0.01 * i))));
    }
    append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 30U);
    EXPECT_EQ(scans[20].imu->has_angular_velocity, unit == 1.0);
  }
}

/// Rates of a gait that the range of the gyro cuts off, and rings of points with times.
std::vector<SyncedScan> walked_with(Preprocessor& stage, double limit) {
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 600; ++i) {
    const double rate = std::clamp(4.0 * std::sin(2.0 * M_PI * 0.005 * i), -limit, limit);
    stage.add_imu(imu(at(0.005 * i), {0.1, rate, 0.0}), "imu");
    if (i % 20 != 10) continue;
    RawScan scan = ring_scan(at(0.005 * i));
    for (int k = 0; k < 100; ++k) scan.cloud.times.push_back(0.001F * static_cast<float>(k));
    scan.times_are_absolute = true;
    append(scans, stage.process(std::move(scan)));
  }
  append(scans, stage.flush());
  return scans;
}

// Rates that end at a limit are not the vehicle's.
TEST(Preprocessor, DoesNotUseAGyroAtTheEndOfItsRange) {
  PreprocessingConfig config;
  config.use_velocity = config.use_gnss = false;
  Preprocessor clipped(config, identity_lookup), whole(config, identity_lookup);
  const auto few = walked_with(clipped, 3.0);
  const auto all = walked_with(whole, 10.0);
  ASSERT_EQ(few.size(), all.size());
  const auto has_rate = [](const SyncedScan& scan) {
    return scan.imu && scan.imu->has_angular_velocity;
  };
  int kept = 0;
  for (std::size_t i = 1; i + 1 < all.size(); ++i) {
    EXPECT_TRUE(has_rate(all[i]));
    if (!has_rate(few[i])) continue;
    ++kept;
    EXPECT_NEAR(few[i].imu->angular_velocity.y(), all[i].imu->angular_velocity.y(), 0.05);
  }
  EXPECT_GT(kept, 3);
  EXPECT_LT(kept, 25);
  const std::string said = test::messages_of(clipped), range = "end at 3.0 rad/s";
  EXPECT_NE(said.find(range), std::string::npos) << said;
  EXPECT_EQ(said.find(range), said.rfind(range)) << "it is said once";
  EXPECT_EQ(test::messages_of(whole).find(range), std::string::npos);
}

// On legs it is another one than that at the stamp, and a front end that took the one for the other
// called the gyro wrong.
TEST(Preprocessor, GivesTheMeanRateOfTheSweepWithTimesThatStay) {
  PreprocessingConfig config;
  config.use_velocity = config.use_gnss = false;
  Preprocessor deskewed(config, identity_lookup);
  config.deskewing = false;
  Preprocessor raw(config, identity_lookup);
  const auto expected = walked_with(deskewed, 10.0);
  const auto scans = walked_with(raw, 10.0);
  ASSERT_EQ(scans.size(), expected.size());
  double largest = 0.0;
  for (std::size_t i = 1; i + 1 < scans.size(); ++i) {
    ASSERT_TRUE(scans[i].imu->has_angular_velocity);
    EXPECT_TRUE(scans[i].scan.cloud.has_times());
    EXPECT_FALSE(scans[i].uneven_turning) << "nothing was removed";
    EXPECT_EQ(scans[i].imu->angular_velocity, expected[i].imu->angular_velocity);
    const double time = to_seconds(scans[i].scan.stamp - at(0.0));
    const double at_stamp = 4.0 * std::sin(2.0 * M_PI * time);
    largest = std::max(largest, std::abs(scans[i].imu->angular_velocity.y() - at_stamp));
  }
  EXPECT_GT(largest, 0.5);
  EXPECT_FALSE(scans.back().imu && scans.back().imu->has_angular_velocity)
      << "the samples end within the sweep";
}

TEST(Preprocessor, WaitsForTheTransformOfTheScan) {
  bool known = false;
  Preprocessor stage({}, [&](const std::string&) {
    return known ? std::optional<Pose>(Pose::Identity()) : std::nullopt;
  });
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 40; ++i) append(scans, stage.process(ring_scan(at(0.1 * i))));
  EXPECT_TRUE(scans.empty());
  EXPECT_EQ(stage.counters().scans_without_extrinsic, 10U);  // the queue holds 30
  const auto diagnostics = stage.take_diagnostics();
  ASSERT_EQ(diagnostics.size(), 1U);
  EXPECT_NE(diagnostics[0].text.find("no transform from 'lidar'"), std::string::npos);
  EXPECT_EQ(diagnostics[0].level, Diagnostic::Level::kWarning);
  known = true;
  append(scans, stage.process(ring_scan(at(4.0))));
  append(scans, stage.flush());
  EXPECT_EQ(scans.size(), 31U);
}

TEST(Preprocessor, UsesNoSensorWithoutATransform) {
  Preprocessor stage({}, [](const std::string& frame) {
    return frame == "lidar" ? std::optional<Pose>(Pose::Identity()) : std::nullopt;
  });
  auto scans = drive(stage, 2.0, kNothingMissing);
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 20U);
  for (const SyncedScan& scan : scans) EXPECT_FALSE(scan.imu || scan.velocity || scan.gnss);
  const auto diagnostics = stage.take_diagnostics();
  EXPECT_EQ(diagnostics.size(), 4U);  // imu, velocity, gnss; and no point times
  const auto is_info = [](const Diagnostic& diagnostic) {
    return diagnostic.level == Diagnostic::Level::kInfo;
  };
  EXPECT_EQ(std::count_if(diagnostics.begin(), diagnostics.end(), is_info), 1) << "no point times";
}

TEST(Preprocessor, ConvertsTheUnitsOfTheImu) {
  PreprocessingConfig config;
  config.imu_acceleration_unit = AccelerationUnit::kStandardGravity;
  config.imu_angular_unit = AngularUnit::kDegrees;
  Preprocessor stage(config, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 100; ++i) {
    ImuSample sample = imu(at(0.01 * i), {0.0, 0.0, 90.0});
    sample.linear_acceleration = {0.0, 0.0, 1.0};
    stage.add_imu(sample, "imu");
    if (i == 50) append(scans, stage.process(ring_scan(at(0.5))));
  }
  append(scans, stage.take_complete());
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_NEAR(scans[0].imu->angular_velocity.z(), M_PI / 2.0, 1e-9);
  EXPECT_NEAR(scans[0].imu->linear_acceleration.z(), 9.80665, 1e-9);
}

TEST(Preprocessor, LearnsTheGyroBiasWhileStanding) {
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 500; ++i) {
    const double t = 0.01 * i;
    const bool drives = t > 3.0;
    stage.add_imu(imu(at(t), {0.01, -0.02, drives ? 0.53 : 0.03}), "imu");
    stage.add_velocity(velocity(at(t), {drives ? 5.0 : 0.0, 0.0, 0.0}), "imu");
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
  }
  append(scans, stage.flush());
  const Eigen::Vector3d rate = scans[45].imu->angular_velocity;
  EXPECT_TRUE(near(rate, Eigen::Vector3d(0.0, 0.0, 0.5), 1e-6));
}

/// The rates at the scans of a drive that stands, then turns; each velocity comes `delay` samples
/// of the IMU after its time.
std::vector<Eigen::Vector3d> rates_with_late_velocities(int delay) {
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 500; ++i) {
    const auto drives = [](int sample) { return sample > 195; };
    stage.add_imu(imu(at(0.01 * i), {0.01, -0.02, drives(i) ? 0.04 : 0.03}), "imu");
    const int late = i - delay;
    const Eigen::Vector3d speed(drives(late) ? 5.0 : 0.0, 0.0, 0.0);
    if (late >= 0) stage.add_velocity(velocity(at(0.01 * late), speed), "imu");
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(0.01 * i))));
    append(scans, stage.take_complete());
  }
  std::vector<Eigen::Vector3d> rates;
  for (const SyncedScan& scan : scans) rates.push_back(scan.imu->angular_velocity);
  return rates;
}

// The nodes and map_bag read the samples in different orders, and have to make the same map.
TEST(Preprocessor, DoesNotDependOnTheOrderOfArrival) {
  const auto prompt = rates_with_late_velocities(0);
  const auto late = rates_with_late_velocities(15);
  ASSERT_GT(late.size(), 45U);
  for (std::size_t i = 0; i < late.size(); ++i) EXPECT_EQ(prompt[i], late[i]) << i;
}

/// Drives `metres` to the north-east with an IMU whose heading is off by `error`, and with that
/// speed on the wheels (m/s).
SyncedScan last_of_drive_with_heading(double error, ImuOrientation mode, double metres,
                                      double speed = 10.0) {
  PreprocessingConfig config;
  config.imu_orientation = mode;
  Preprocessor stage(config, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < static_cast<int>(metres * 10.0); ++i) {
    const double t = 0.01 * i;
    ImuSample sample = imu(at(t));
    sample.orientation = exp_so3({0.0, 0.0, M_PI / 4.0 + error});
    stage.add_imu(sample, "imu");
    stage.add_velocity(velocity(at(t), {speed, 0.0, 0.0}), "imu");
    const double along = 10.0 * t / std::sqrt(2.0);
    if (i % 10 == 0) {
      stage.add_gnss(fix(at(t), 49.0 + along / 111211.0, 8.4 + along / 73172.0), "gps");
    }
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
  }
  append(scans, stage.take_complete());
  return scans.back();
}

TEST(Preprocessor, AcceptsAHeadingThatTheTrackConfirms) {
  EXPECT_TRUE(last_of_drive_with_heading(0.1, ImuOrientation::kAuto, 40.0).gnss->R_enu_base);
  EXPECT_FALSE(last_of_drive_with_heading(1.0, ImuOrientation::kAuto, 40.0).gnss->R_enu_base);
  EXPECT_FALSE(last_of_drive_with_heading(0.0, ImuOrientation::kAuto, 8.0).gnss->R_enu_base);
  EXPECT_TRUE(last_of_drive_with_heading(1.0, ImuOrientation::kEnu, 40.0).gnss->R_enu_base);
  EXPECT_FALSE(last_of_drive_with_heading(0.0, ImuOrientation::kNone, 40.0).gnss->R_enu_base);
}

TEST(Preprocessor, AcceptsTheHeadingOfAReversingVehicle) {
  EXPECT_TRUE(
      last_of_drive_with_heading(M_PI, ImuOrientation::kAuto, 40.0, -10.0).gnss->R_enu_base);
  EXPECT_FALSE(
      last_of_drive_with_heading(0.0, ImuOrientation::kAuto, 40.0, -10.0).gnss->R_enu_base);
}

TEST(Preprocessor, ReturnsTheLeverArm) {
  Preprocessor stage({}, [](const std::string& frame) {
    return std::optional<Pose>(
        Pose{Eigen::Quaterniond::Identity(), {frame == "gps" ? 1.5 : 0.0, 0.0, 0.3}});
  });
  auto scans = drive(stage, 2.0, kNothingMissing);
  EXPECT_TRUE(near(scans.back().gnss->p_base_antenna, Eigen::Vector3d(1.5, 0.0, 0.3), 1e-12));
}

/// A wall north of a vehicle that drives a bend has to be straight after the compensation of the
/// motion, seen by a sensor that is turned by 90 degrees and a metre off: velocity and rate are
/// measured in base_link, the points in the frame of the sensor.
TEST(Preprocessor, AppliesTheExtrinsicInTheRightDirection) {
  const Pose T_base_lidar{exp_so3({0.0, 0.0, M_PI / 2.0}), {1.0, 0.0, 0.5}};
  Preprocessor stage({}, [&](const std::string& frame) {
    return frame == "lidar" ? T_base_lidar : Pose::Identity();
  });
  constexpr double kSpeed = 10.0;     // m/s
  constexpr double kYawRate = 0.4;    // rad/s
  constexpr double kDuration = 0.09;  // s, of a scan after its stamp
  const auto T_map_base = [&](double t) {
    const double yaw = kYawRate * t;
    const double radius = kSpeed / kYawRate;
    return Pose{exp_so3({0.0, 0.0, yaw}),
                {radius * std::sin(yaw), radius * (1.0 - std::cos(yaw)), 0.0}};
  };
  std::vector<SyncedScan> scans;
  for (int tick = 0; tick < 120; ++tick) {
    const double t = 0.01 * tick;
    stage.add_imu(imu(at(t), {0.0, 0.0, kYawRate}), "imu");
    stage.add_velocity(velocity(at(t), {kSpeed, 0.0, 0.0}, {0.0, 0.0, kYawRate}), "imu");
    if (tick % 10 != 5) continue;
    RawScan scan;
    scan.stamp = at(t);
    scan.frame_id = "lidar";
    for (int i = 0; i <= 100; ++i) {
      const double after = kDuration * i / 100.0;
      const Eigen::Vector3d p_map(0.1 * i, 25.0, 1.0);
      const Eigen::Vector3f p =
          ((T_map_base(t + after) * T_base_lidar).inverse() * p_map).cast<float>();
      scan.cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
      scan.cloud.times.push_back(static_cast<float>(after));
    }
    append(scans, stage.process(std::move(scan)));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 12U);
  scans.pop_back();  // nothing was measured until its end
  for (const SyncedScan& scan : scans) {
    ASSERT_FALSE(scan.scan.cloud.has_times()) << "the motion is compensated";
    const Pose T_map_lidar = T_map_base(to_seconds(scan.scan.stamp - at(0.0))) * T_base_lidar;
    for (std::size_t i = 0; i < scan.scan.cloud.size(); ++i) {
      const Eigen::Vector3d p_map =
          T_map_lidar * scan.scan.cloud.points[i].position().cast<double>();
      ASSERT_NEAR(p_map.x(), 0.1 * static_cast<double>(i), 0.005);
      ASSERT_NEAR(p_map.y(), 25.0, 0.005);
      ASSERT_NEAR(p_map.z(), 1.0, 0.005);
    }
  }
}

TEST(Preprocessor, AcceptsLateImuSamplesOfAnyRate) {
  for (const double rate : {100.0, 400.0, 1000.0}) {
    Preprocessor stage({}, identity_lookup);
    std::vector<SyncedScan> scans;
    double next = 0.0;
    for (int tick = 0; tick < 300; ++tick) {
      for (; next + 0.15 <= 0.01 * tick; next += 1.0 / rate) {
        stage.add_imu(imu(at(next), {0.0, 0.0, 0.2}), "imu");
        append(scans, stage.take_complete());
      }
      if (tick % 10 == 5) append(scans, stage.process(ring_scan(at(0.01 * tick))));
    }
    append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 30U) << rate;
    std::size_t with_imu = 0;
    for (const SyncedScan& scan : scans) with_imu += scan.imu.has_value() ? 1 : 0;
    EXPECT_GE(with_imu, 27U) << rate;
  }
}

PointCloud cloud_of(const PreprocessingConfig& config, RawScan scan) {
  Preprocessor stage(config, identity_lookup);
  auto scans = stage.process(std::move(scan));
  append(scans, stage.flush());
  return scans.at(0).scan.cloud;
}

TEST(Preprocessor, TreatsPackedPointsLikeOthers) {
  std::vector<PreprocessingConfig> configs(3);
  configs[1].point_times = PointTimes::kAzimuth;
  configs[2].vertical_angle_correction = 0.205 * kRadPerDeg;
  const RawScan read = ring_scan(at(0.0));
  for (const PreprocessingConfig& config : configs) {
    const auto memory = std::make_shared<const std::vector<Point>>(read.cloud.points);
    RawScan packed = read;
    packed.cloud.points.assign(read.cloud.size(), {});
    packed.packed = {memory, reinterpret_cast<const unsigned char*>(memory->data()), 16, 12};
    const PointCloud expected = cloud_of(config, read), cloud = cloud_of(config, packed);
    ASSERT_EQ(cloud.size(), expected.size());
    EXPECT_EQ(cloud.times, expected.times);
    EXPECT_EQ(std::memcmp(cloud.points.data(), expected.points.data(), 16 * cloud.size()), 0);
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
