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
    if (tick % 10 == 0 && !missing("gnss", t)) stage.add_gnss(fix(at(t)), "gps");
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

}  // namespace
}  // namespace lidar_mapping::preprocessing
