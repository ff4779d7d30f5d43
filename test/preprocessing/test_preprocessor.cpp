#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/preprocessor.hpp"

#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::append;
using test::at;
using test::fix;
using test::identity_lookup;
using test::imu;
using test::ring_scan;
using test::velocity;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Which sensors a drive has.
struct Sensors {
  bool imu = true;
  bool velocity = true;
  bool gnss = true;
};

/// A drive straight ahead at 10 m/s in the order in which a recorder would store it: IMU 100 Hz,
/// velocity 50 Hz, GNSS 10 Hz, scans 10 Hz. `missing(name, t)` leaves samples out.
template <typename Missing>
std::vector<SyncedScan> drive(Preprocessor& stage, double seconds, const Missing& missing,
                              double start = 0.0) {
  std::vector<SyncedScan> out;
  const int ticks = static_cast<int>(std::lround(seconds * 100.0));
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = start + 0.01 * tick;
    if (!missing("imu", t)) stage.add_imu(imu(at(t)), "imu");
    if (tick % 2 == 0 && !missing("velocity", t)) {
      stage.add_velocity(velocity(at(t), {10.0, 0.0, 0.0}), "imu");
    }
    if (tick % 10 == 0 && !missing("gnss", t)) {
      stage.add_gnss(fix(at(t), 49.0, 8.4 + 10.0 * (t - start) / 73172.0), "gps");
    }
    if (tick % 10 == 5 && !missing("points", t)) append(out, stage.process(ring_scan(at(t))));
  }
  return out;
}

const auto kNothingMissing = [](const std::string&, double) { return false; };

TEST(Preprocessor, KeepsTheStampOfEveryScanBitForBit) {  // F1, F8
  Preprocessor stage({}, identity_lookup);
  const auto scans = drive(stage, 3.0, kNothingMissing);
  ASSERT_GE(scans.size(), 28U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Stamp expected = at(0.05 + 0.1 * static_cast<double>(i));
    EXPECT_NEAR(static_cast<double>(scans[i].scan.stamp - expected), 0.0, 1.0);
    ASSERT_TRUE(i == 0 || (scans[i].imu && scans[i].velocity && scans[i].gnss));
    if (!scans[i].gnss) continue;
    EXPECT_EQ(scans[i].imu->stamp, scans[i].scan.stamp);
    EXPECT_EQ(scans[i].velocity->stamp, scans[i].scan.stamp);
    EXPECT_EQ(scans[i].gnss->stamp, scans[i].scan.stamp);
  }
}

TEST(Preprocessor, RunsWithEverySubsetOfSensors) {  // F12
  for (int subset = 0; subset < 8; ++subset) {
    const auto missing = [&](const std::string& name, double) {
      return (name == "imu" && (subset & 1)) || (name == "velocity" && (subset & 2)) ||
             (name == "gnss" && (subset & 4));
    };
    Preprocessor stage({}, identity_lookup);
    auto scans = drive(stage, 2.0, missing);
    append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 20U) << subset;
    EXPECT_EQ(scans[10].imu.has_value(), !(subset & 1));
    EXPECT_EQ(scans[10].velocity.has_value(), !(subset & 2));
    EXPECT_EQ(scans[10].gnss.has_value(), !(subset & 4));
  }
}

TEST(Preprocessor, GoesOnAfterAGapOfAnySensor) {  // F2
  for (const std::string name : {"imu", "velocity", "gnss"}) {
    Preprocessor stage({}, identity_lookup);
    auto scans = drive(stage, 6.0, [&](const std::string& sensor, double t) {
      return sensor == name && t > 2.001 && t < 4.0;
    });
    append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 60U) << name;
    const auto has = [&](const SyncedScan& scan) {
      return name == "imu"        ? scan.imu.has_value()
             : name == "velocity" ? scan.velocity.has_value()
                                  : scan.gnss.has_value();
    };
    EXPECT_TRUE(has(scans[18])) << name;
    EXPECT_FALSE(has(scans[30])) << name;
    EXPECT_TRUE(has(scans[45])) << name;
  }
}

TEST(Preprocessor, WaitsForSlowAndLateSensors) {  // F3
  for (const double period : {0.01, 0.1, 0.25, 0.5, 1.0}) {
    for (const double delay : {0.0, 0.05, 0.12, 0.3}) {
      Preprocessor stage({}, identity_lookup);
      std::vector<SyncedScan> scans;
      double next = 0.0;
      for (int tick = 0; tick < 600; ++tick) {
        for (; next + delay <= 0.01 * tick; next += period) {
          stage.add_gnss(fix(at(next)), "gps");
          append(scans, stage.take_complete());
        }
        if (tick % 10 == 5) append(scans, stage.process(ring_scan(at(0.01 * tick))));
      }
      append(scans, stage.flush());
      ASSERT_EQ(scans.size(), 60U) << period << " " << delay;
      const auto with_gnss = std::count_if(scans.begin(), scans.end(),
                                           [](const auto& scan) { return scan.gnss.has_value(); });
      if (period + delay < 0.3) {
        EXPECT_GE(with_gnss, 55) << period << " " << delay;
      }
    }
  }
}

TEST(Preprocessor, DoesNotWaitForASensorThatHasGone) {
  Preprocessor stage({}, identity_lookup);
  const auto scans =
      drive(stage, 6.0, [](const std::string& name, double t) { return name == "imu" && t > 1.0; });
  // The last scans but the one that waits for the velocity after it are out without a flush.
  EXPECT_GE(scans.size(), 58U);
}

TEST(Preprocessor, GivesEveryScanOnceAndInOrder) {  // F7, F8
  std::mt19937 engine(5);
  std::vector<int> order(40);
  for (int i = 0; i < 40; ++i) order[static_cast<std::size_t>(i)] = i;
  for (std::size_t i = 0; i + 1 < order.size(); i += 2) {
    if (engine() % 2 == 0) std::swap(order[i], order[i + 1]);
  }
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  // 20 scans a second, an IMU that is 150 ms late.
  int samples = 0;
  for (const int i : order) {
    for (; 0.01 * samples < 0.05 * i - 0.15; ++samples) {
      stage.add_imu(imu(at(0.01 * samples)), "imu");
    }
    append(scans, stage.process(ring_scan(at(0.05 * i))));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 40U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].scan.stamp, at(0.05 * static_cast<double>(i)));
  }
}

TEST(Preprocessor, BeginsAnewWhenTimeGoesBack) {  // F7
  Preprocessor fresh({}, identity_lookup), stage({}, identity_lookup);
  auto expected = drive(fresh, 3.0, kNothingMissing);
  append(expected, fresh.flush());
  drive(stage, 3.0, kNothingMissing, 100.0);
  stage.take_notices();
  auto again = drive(stage, 3.0, kNothingMissing);
  append(again, stage.flush());
  EXPECT_GE(stage.counters().resets, 1U);
  const auto notices = stage.take_notices();
  EXPECT_TRUE(std::any_of(notices.begin(), notices.end(), [](const Notice& notice) {
    return notice.text.find("time went back") != std::string::npos;
  }));
  ASSERT_EQ(again.size(), expected.size() - 1);  // the first one might have been stray
  for (std::size_t i = 1; i < again.size(); ++i) {
    EXPECT_EQ(again[i].scan.stamp, expected[i + 1].scan.stamp);
    EXPECT_EQ(again[i].imu.has_value(), expected[i + 1].imu.has_value());
  }
}

/// A drive in which the stamp of one message of an input is something else.
std::vector<SyncedScan> drive_with_stray(Preprocessor& stage, const std::string& input,
                                         Stamp stray) {
  bool done = false;
  std::vector<SyncedScan> early;
  const auto strays = [&](const std::string& name, double t) {
    if (done || name != input || t < 1.5) return false;
    done = true;
    if (name == "imu") stage.add_imu(imu(stray), "imu");
    if (name == "velocity") stage.add_velocity(velocity(stray, {10.0, 0.0, 0.0}), "imu");
    if (name == "gnss") stage.add_gnss(fix(stray), "gps");
    if (name == "points") append(early, stage.process(ring_scan(stray)));
    return true;
  };
  auto scans = drive(stage, 3.0, strays);
  append(scans, stage.flush());
  append(scans, std::move(early));
  return scans;
}

TEST(Preprocessor, IsNotMisledByOneStrayStamp) {
  for (const char* input : {"imu", "velocity", "gnss", "points"}) {
    for (const Stamp stray : {Stamp{0}, at(100.0), at(-50.0), from_seconds(4e9)}) {
      Preprocessor stage({}, identity_lookup);
      const auto scans = drive_with_stray(stage, input, stray);
      EXPECT_EQ(stage.counters().resets, 0U) << input;
      EXPECT_EQ(scans.size(), std::string(input) == "points" ? 29U : 30U) << input << stray;
      EXPECT_TRUE(scans[20].imu && scans[20].velocity && scans[20].gnss) << input << stray;
    }
  }
}

TEST(Preprocessor, SaysEachReasonForRefusedFixesOnce) {
  Preprocessor stage({}, identity_lookup);
  for (int i = 0; i < 100; ++i) {
    GnssFix poor = fix(at(0.1 * i));
    poor.covariance = (400.0 + i) * Eigen::Matrix3d::Identity();
    stage.add_gnss(poor, "gps");
    stage.add_gnss(fix(at(0.1 * i + 0.05), 49.0, 8.4, 50001.0 + i), "gps");
  }
  EXPECT_EQ(stage.counters().gnss_refused, 200U);
  EXPECT_EQ(stage.take_notices().size(), 2U);
}

TEST(Preprocessor, WaitsForAnImuWhoseOtherClockIsTakenAway) {
  PreprocessingConfig config;
  config.imu_time_offset = -3600.0;
  Preprocessor stage(config, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 20; ++i) {
    append(scans, stage.process(ring_scan(at(0.1 * i + 0.05))));
    for (int k = 0; k < 10; ++k) stage.add_imu(imu(at(3600.0 + 0.1 * i + 0.01 * k)), "imu");
    append(scans, stage.take_complete());
  }
  ASSERT_EQ(scans.size(), 20U);
  for (const SyncedScan& scan : scans) EXPECT_TRUE(scan.imu.has_value());
}

TEST(Preprocessor, DoesNotUseAGyroThatTurnsAsNobodyDrives) {
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
  const auto notices = stage.take_notices();
  EXPECT_TRUE(std::any_of(notices.begin(), notices.end(), [](const Notice& notice) {
    return notice.text.find("imu_angular_unit") != std::string::npos;
  }));
}

TEST(Preprocessor, GoesOnAfterALongPauseOfOneSensor) {
  Preprocessor stage({}, identity_lookup);
  const auto pause = [](const std::string& name, double t) {
    return name == "gnss" && t > 1.0 && t < 14.0;
  };
  auto scans = drive(stage, 16.0, pause);
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 160U);
  EXPECT_FALSE(scans[80].gnss);
  EXPECT_TRUE(scans[141].gnss);  // 14.15 s
  EXPECT_EQ(stage.counters().gnss_refused, 0U);
}

TEST(Preprocessor, TakesAJumpOfTimeThatGoesOn) {
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 20; ++i) append(scans, stage.process(ring_scan(at(0.1 * i))));
  for (int i = 0; i < 20; ++i) append(scans, stage.process(ring_scan(at(300.0 + 0.1 * i))));
  append(scans, stage.flush());
  EXPECT_EQ(scans.size(), 39U);  // the first after the jump might have been stray
  EXPECT_EQ(stage.counters().scans_out_of_order, 1U);
}

TEST(Preprocessor, StaysFiniteWhateverComes) {  // F5
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.01 * i;
    ImuSample bad = imu(at(t));
    if (i % 3 == 0) bad.angular_velocity.y() = kNaN;
    if (i % 5 == 0) bad.orientation = Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0);
    if (i % 7 == 0) bad.orientation = Eigen::Quaterniond(kNaN, 0.0, 0.0, 1.0);
    stage.add_imu(bad, "imu");
    stage.add_imu(bad, "imu");
    stage.add_velocity(velocity(at(t), {i % 4 == 0 ? kNaN : 1.0, 0.0, 0.0}), "imu");
    stage.add_gnss(fix(at(t), i % 2 == 0 ? kNaN : 49.0), "gps");
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 20U);
  EXPECT_GT(stage.counters().samples_refused, 200U);
  for (const SyncedScan& scan : scans) {
    if (scan.imu) {
      EXPECT_TRUE(scan.imu->angular_velocity.allFinite());
      EXPECT_FALSE(scan.imu->orientation.has_value());
    }
    if (scan.velocity) {
      EXPECT_TRUE(scan.velocity->linear.allFinite());
    }
    if (scan.gnss) {
      EXPECT_TRUE(scan.gnss->p_enu_antenna.allFinite());
    }
    for (const Point& point : scan.scan.cloud.points) EXPECT_TRUE(point.position().allFinite());
  }
}

TEST(Preprocessor, DropsScansWithoutPointsAndSaysSo) {  // F20
  Preprocessor stage({}, identity_lookup);
  RawScan empty{at(0.0), "lidar", {}};
  RawScan nan = ring_scan(at(0.1));
  for (Point& p : nan.cloud.points) p.x = std::numeric_limits<float>::quiet_NaN();
  RawScan few = ring_scan(at(0.2), 10);
  RawScan far = ring_scan(at(0.3));
  for (Point& p : far.cloud.points) p.x = 1000.0F;
  for (const RawScan& scan : {empty, nan, few, far}) EXPECT_TRUE(stage.process(scan).empty());
  EXPECT_TRUE(stage.flush().empty());
  EXPECT_EQ(stage.counters().scans_without_points, 4U);
  EXPECT_EQ(stage.counters().points_not_finite, 100U);
  EXPECT_FALSE(stage.take_notices().empty());
}

TEST(Preprocessor, WaitsForTheTransformOfTheScan) {  // F21
  bool known = false;
  Preprocessor stage({}, [&](const std::string&) {
    return known ? std::optional<Pose>(Pose::Identity()) : std::nullopt;
  });
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 40; ++i) append(scans, stage.process(ring_scan(at(0.1 * i))));
  EXPECT_TRUE(scans.empty());
  EXPECT_EQ(stage.counters().scans_without_extrinsic, 10U);  // the queue holds 30
  const auto notices = stage.take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_NE(notices[0].text.find("no transform from 'lidar'"), std::string::npos);
  EXPECT_EQ(notices[0].level, Notice::Level::kWarning);
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
  const auto notices = stage.take_notices();
  EXPECT_EQ(notices.size(), 4U);  // imu, velocity, gnss; and no point times
  const auto is_info = [](const Notice& notice) { return notice.level == Notice::Level::kInfo; };
  EXPECT_EQ(std::count_if(notices.begin(), notices.end(), is_info), 1) << "no point times";
}

TEST(Preprocessor, AppliesTimeOffsets) {
  PreprocessingConfig config;
  config.imu_time_offset = 0.05;
  config.velocity_time_offset = -0.05;
  Preprocessor stage(config, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 300; ++i) {
    const double t = 0.01 * i;
    stage.add_imu(imu(at(t - 0.05), {0.0, 0.0, 0.1 * t}), "imu");
    stage.add_velocity(velocity(at(t + 0.05), {t, 0.0, 0.0}), "imu");
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
  }
  ASSERT_GT(scans.size(), 20U);
  for (const SyncedScan& scan : scans) {
    const double t = to_seconds(scan.scan.stamp - at(0.0));
    if (scan.imu) {
      EXPECT_NEAR(scan.imu->angular_velocity.z(), 0.1 * t, 0.021);
    }
    if (scan.velocity) {
      EXPECT_NEAR(scan.velocity->linear.x(), t, 1e-6);
    }
  }
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
  EXPECT_LT((rate - Eigen::Vector3d(0.0, 0.0, 0.5)).norm(), 1e-6);
}

/// Drives `metres` to the north-east with an IMU whose heading is off by `error`.
SyncedScan last_of_drive_with_heading(double error, ImuOrientation mode, double metres) {
  PreprocessingConfig config;
  config.imu_orientation = mode;
  Preprocessor stage(config, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < static_cast<int>(metres * 10.0); ++i) {
    const double t = 0.01 * i;
    ImuSample sample = imu(at(t));
    sample.orientation = exp_so3({0.0, 0.0, M_PI / 4.0 + error});
    stage.add_imu(sample, "imu");
    const double along = 10.0 * t / std::sqrt(2.0);
    if (i % 10 == 0) {
      stage.add_gnss(fix(at(t), 49.0 + along / 111211.0, 8.4 + along / 73172.0), "gps");
    }
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
  }
  append(scans, stage.take_complete());
  return scans.back();
}

TEST(Preprocessor, BelievesAHeadingThatTheTrackConfirms) {  // F27
  EXPECT_TRUE(last_of_drive_with_heading(0.1, ImuOrientation::kAuto, 40.0).gnss->R_enu_base);
  EXPECT_FALSE(last_of_drive_with_heading(1.0, ImuOrientation::kAuto, 40.0).gnss->R_enu_base);
  EXPECT_FALSE(last_of_drive_with_heading(0.0, ImuOrientation::kAuto, 8.0).gnss->R_enu_base);
  EXPECT_TRUE(last_of_drive_with_heading(1.0, ImuOrientation::kEnu, 40.0).gnss->R_enu_base);
  EXPECT_FALSE(last_of_drive_with_heading(0.0, ImuOrientation::kNone, 40.0).gnss->R_enu_base);
}

TEST(Preprocessor, HandsTheLeverArmOn) {  // F26
  Preprocessor stage({}, [](const std::string& frame) {
    return std::optional<Pose>(
        Pose{Eigen::Quaterniond::Identity(), {frame == "gps" ? 1.5 : 0.0, 0.0, 0.3}});
  });
  auto scans = drive(stage, 2.0, kNothingMissing);
  EXPECT_LT((scans.back().gnss->p_base_antenna - Eigen::Vector3d(1.5, 0.0, 0.3)).norm(), 1e-12);
}

TEST(Preprocessor, RefusesAConfigurationThatContradictsItself) {
  const auto& checks = PreprocessingConfig::schema().checks();
  const auto problem = [&](const PreprocessingConfig& config) {
    std::string all;
    for (const auto& check : checks) all += check(config);
    return all;
  };
  EXPECT_EQ(problem({}), "");
  PreprocessingConfig config;
  config.distance_near_thresh = 300.0;
  EXPECT_NE(problem(config), "");
  config = {};
  config.vehicle_box = {1, 0, 0, 0, 0, 0};
  EXPECT_NE(problem(config), "");
  config = {};
  config.use_datum = true;
  config.datum = {120.0, 0.0, 0.0};
  EXPECT_NE(problem(config), "");
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
