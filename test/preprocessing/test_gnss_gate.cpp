#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/gnss_gate.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;

/// Fixes and motion of a simulated drive through the stage; the scans carry no real points.
struct Outcome {
  std::size_t with_gnss = 0;
  std::size_t scans = 0;
  double worst = 0.0;  ///< m, horizontal, to the true antenna
  double ahead = 0.0;  ///< s of way by which positions are ahead, mean over the last 40 s
  std::size_t refused = 0;
};

Outcome drive_with(const simulation::Drive& drive, bool with_motion, bool gating,
                   double delay = 0.0) {
  PreprocessingConfig config;
  config.gnss_gating = gating;
  const GeodeticDatum datum = drive.datum();
  config.use_datum = true;
  config.datum = {datum.latitude_deg, datum.longitude_deg, datum.altitude_m};
  const auto& mounting = drive.mounting();
  Preprocessor stage(config, [&](const std::string& frame) -> std::optional<Pose> {
    if (frame == "gps") return Pose{Eigen::Quaterniond::Identity(), mounting.p_base_antenna};
    return frame == "imu" ? mounting.T_base_imu : Pose::Identity();
  });
  const auto imus = drive.imu();
  const auto velocities = drive.velocity();
  auto fixes = drive.gnss();
  for (GnssFix& fix : fixes) fix.stamp += from_seconds(delay);
  std::size_t i = 0, v = 0, g = 0;
  std::vector<SyncedScan> scans;
  for (std::size_t k = 0; k < drive.scan_count(); ++k) {
    const Stamp stamp = drive.scan_stamp(k);
    for (; with_motion && i < imus.size() && imus[i].stamp <= stamp; ++i) {
      stage.add_imu(imus[i], "imu");
    }
    for (; with_motion && v < velocities.size() && velocities[v].stamp <= stamp; ++v) {
      stage.add_velocity(velocities[v], "imu");
    }
    for (; g < fixes.size() && fixes[g].stamp <= stamp; ++g) stage.add_gnss(fixes[g], "gps");
    test::append(scans, stage.process(test::ring_scan(stamp)));
  }
  test::append(scans, stage.flush());
  Outcome outcome;
  outcome.scans = scans.size();
  outcome.refused = stage.counters().gnss_refused;
  double way = 0.0, ahead = 0.0;  // both times the speed
  for (const SyncedScan& scan : scans) {
    if (!scan.gnss) continue;
    ++outcome.with_gnss;
    const auto true_antenna = [&](Stamp stamp) -> Eigen::Vector3d {
      return drive.trajectory().pose(stamp) * mounting.p_base_antenna;
    };
    const Stamp stamp = scan.scan.stamp;
    const Eigen::Vector3d off = scan.gnss->p_enu_antenna - true_antenna(stamp);
    outcome.worst = std::max(outcome.worst, off.head<2>().norm());
    if (stamp < scans.back().scan.stamp - from_seconds(40.0)) continue;
    const Eigen::Vector3d velocity =
        (true_antenna(stamp) - true_antenna(stamp - from_seconds(0.1))) / 0.1;
    way += velocity.squaredNorm();
    ahead += off.dot(velocity);
  }
  outcome.ahead = ahead / way;
  return outcome;
}

TEST(GnssGate, TakesAllOfACleanDrive) {
  const Outcome outcome = drive_with(simulation::Drive({}), true, true);
  EXPECT_EQ(outcome.refused, 0U);
  EXPECT_GE(outcome.with_gnss, outcome.scans - 2);
  EXPECT_LT(outcome.worst, 0.15);
}

TEST(GnssGate, RefusesJumpsAndTakesTheReturn) {  // F24
  for (const double metres : {5.0, 50.0}) {
    simulation::DriveOptions options;
    options.gnss_jumps = {{40.0, metres}, {90.0, metres}};
    options.duration = 120.0;
    const simulation::Drive drive(options);
    const Outcome off = drive_with(drive, true, false);
    EXPECT_GT(off.worst, 0.9 * metres);
    const Outcome on = drive_with(drive, true, true);
    EXPECT_LT(on.worst, 0.7) << metres;
    EXPECT_NEAR(static_cast<double>(on.refused), 200.0, 4.0) << metres;
    EXPECT_GT(on.with_gnss, on.scans - 240) << metres;
  }
}

TEST(GnssGate, TakesFixesAgainAfterAnOutage) {
  simulation::DriveOptions options;
  options.gnss_outages = {{40.0, 100.0}};
  const Outcome outcome = drive_with(simulation::Drive(options), true, true);
  EXPECT_NEAR(static_cast<double>(outcome.refused), 600.0, 5.0);  // those without a fix
  EXPECT_GT(outcome.with_gnss, outcome.scans - 620);
}

// Who knows the whole drive corrects them, the first ones too.
TEST(GnssTrack, LeavesLateStampsAsTheyAre) {
  simulation::DriveOptions options;
  options.seed = 3;
  const simulation::Drive drive(options);
  for (const double delay : {-0.05, 0.05}) {
    const Outcome outcome = drive_with(drive, true, true, delay);
    EXPECT_NEAR(outcome.ahead, -delay, 0.003) << delay;
    EXPECT_EQ(outcome.refused, 0U) << delay;
    EXPECT_GE(outcome.with_gnss, outcome.scans - 3) << delay;
  }
}

TEST(GnssGate, WithoutMotionRefusesWhatNobodyCanDrive) {
  simulation::DriveOptions options;
  options.gnss_jumps = {{40.0, 50.0}};
  const Outcome outcome = drive_with(simulation::Drive(options), false, true);
  EXPECT_GT(outcome.refused, 3U);
  EXPECT_GT(outcome.with_gnss, outcome.scans - 120);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
