// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include "lidar_mapping/config/load.hpp"

#include "straight_drive.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::append;
using test::at;
using test::drive;
using test::fix;
using test::identity_lookup;
using test::imu;
using test::kNothingMissing;
using test::ring_scan;
using test::velocity;

TEST(Preprocessor, ContinuesAfterAGapOfAnySensor) {
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

TEST(Preprocessor, WaitsForSlowAndLateSensors) {
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

TEST(Preprocessor, DoesNotWaitForAnInactiveSensor) {
  Preprocessor stage({}, identity_lookup);
  const auto scans =
      drive(stage, 6.0, [](const std::string& name, double t) { return name == "imu" && t > 1.0; });
  // The last scans but the one that waits for the velocity after it are out without a flush.
  EXPECT_GE(scans.size(), 58U);
}

TEST(Preprocessor, ResetsWhenTimeGoesBack) {
  Preprocessor fresh({}, identity_lookup), stage({}, identity_lookup);
  auto expected = drive(fresh, 3.0, kNothingMissing);
  append(expected, fresh.flush());
  drive(stage, 3.0, kNothingMissing, 100.0);
  stage.take_diagnostics();
  auto again = drive(stage, 3.0, kNothingMissing);
  append(again, stage.flush());
  EXPECT_GE(stage.counters().resets, 1U);
  EXPECT_NE(test::messages_of(stage).find("time went back"), std::string::npos);
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

TEST(Preprocessor, IgnoresASingleWrongStamp) {
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

TEST(Preprocessor, WaitsForAnImuWithACorrectedTimeOffset) {
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

TEST(Preprocessor, ContinuesAfterALongPauseOfOneSensor) {
  Preprocessor stage({}, identity_lookup);
  const auto pause = [](const std::string& name, double t) {
    return name == "gnss" && t > 1.0 && t < 14.0;
  };
  auto scans = drive(stage, 16.0, pause);
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 160U);
  EXPECT_FALSE(scans[80].gnss);
  EXPECT_TRUE(scans[141].gnss);  // 14.15 s
  const std::string said = test::messages_of(stage);
  EXPECT_NE(said.find("has it ended, or is it another clock? (gnss_time_offset)"),
            std::string::npos)
      << said;
  EXPECT_EQ(stage.counters().gnss_refused, 0U);
}

TEST(Preprocessor, AcceptsALastingJumpOfTime) {
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 20; ++i) append(scans, stage.process(ring_scan(at(0.1 * i))));
  for (int i = 0; i < 20; ++i) append(scans, stage.process(ring_scan(at(300.0 + 0.1 * i))));
  append(scans, stage.flush());
  EXPECT_EQ(scans.size(), 39U);  // the first after the jump might have been stray
  EXPECT_EQ(stage.counters().scans_out_of_order, 1U);
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

/// At 10 m/s a fix that is 0.2 s late lies 2 m behind; the offset has hdl_graph_slam's name, too.
TEST(Preprocessor, AppliesTheTimeOffsetOfGnss) {
  const auto mean_lag = [](const std::string& yaml) {
    const auto config =
        config::load<PreprocessingConfig>({config::parse_yaml(yaml + "gnss_gating: false\n", "")});
    Preprocessor stage(config, identity_lookup);
    std::vector<SyncedScan> scans;
    for (int i = 0; i < 300; ++i) {
      const double t = 0.01 * i;
      if (i % 10 == 0) {
        stage.add_gnss(fix(at(t + 0.2), 49.0, 8.4 + 10.0 * t / 73172.0), "gps");
      }
      if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
    }
    append(scans, stage.flush());
    double sum = 0.0;
    int count = 0;
    for (const SyncedScan& scan : scans) {
      if (!scan.gnss) continue;
      sum += 10.0 * to_seconds(scan.scan.stamp - at(0.0)) - scan.gnss->p_enu_antenna.x();
      ++count;
    }
    EXPECT_GT(count, 20);
    return sum / count;
  };
  EXPECT_NEAR(mean_lag(""), 2.0, 0.05) << "what there is to correct";
  EXPECT_NEAR(mean_lag("gnss_time_offset: -0.2\n"), 0.0, 0.05);
  EXPECT_NEAR(mean_lag("gps_time_offset: -0.2\n"), 0.0, 0.05);
  EXPECT_NEAR(mean_lag("gnss_time_offset: 0.1\n"), 3.0, 0.05);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
