// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "gnss/gnss_gate.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

/// Fixes and motion of a simulated drive through the stage; the scans carry no real points.
struct Outcome {
  std::size_t with_gnss = 0;
  std::size_t scans = 0;
  double worst = 0.0;  ///< m, horizontal, to the true antenna
  double ahead = 0.0;  ///< s of way by which positions are ahead, mean over the last 40 s
  std::size_t refused = 0;
  std::string said;
};

using Spoil = std::function<void(std::vector<GnssFix>&)>;

Outcome drive_with(const simulation::Drive& drive, bool with_motion, bool gating,
                   double delay = 0.0, const Spoil& spoil = nullptr) {
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
  if (spoil) spoil(fixes);
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
  outcome.said = test::messages_of(stage);
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

TEST(GnssGate, AcceptsAllFixesOfACleanDrive) {
  const Outcome outcome = drive_with(simulation::Drive({}), true, true);
  EXPECT_EQ(outcome.refused, 0U);
  EXPECT_GE(outcome.with_gnss, outcome.scans - 2);
  EXPECT_LT(outcome.worst, 0.15);
}

TEST(GnssGate, RejectsJumpsAndAcceptsTheReturn) {
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

TEST(GnssGate, AcceptsFixesAgainAfterAnOutage) {
  simulation::DriveOptions options;
  options.gnss_outages = {{40.0, 100.0}};
  const Outcome outcome = drive_with(simulation::Drive(options), true, true);
  EXPECT_NEAR(static_cast<double>(outcome.refused), 600.0, 5.0);  // those without a fix
  EXPECT_GT(outcome.with_gnss, outcome.scans - 620);
}

// The back end, which knows the whole drive, corrects them, the first ones too.
TEST(GnssTrack, DoesNotChangeLateStamps) {
  simulation::DriveOptions options;
  options.seed = 3;
  const simulation::Drive drive(options);
  for (const double delay : {-0.05, 0.05}) {
    const Outcome outcome = drive_with(drive, true, true, delay);
    EXPECT_NEAR(outcome.ahead, -delay, 0.003) << delay;
    EXPECT_EQ(outcome.refused, 0U) << delay;
    EXPECT_GE(outcome.with_gnss, outcome.scans - 3) << delay;
    const std::string correction =
        delay > 0.0 ? "gnss_time_offset to -0.0" : "gnss_time_offset to 0.0";
    EXPECT_NE(outcome.said.find("positions keep their stamps"), std::string::npos) << outcome.said;
    EXPECT_NE(outcome.said.find(correction), std::string::npos) << outcome.said;
  }
}

TEST(GnssGate, WithoutMotionRejectsImpossibleSpeeds) {
  simulation::DriveOptions options;
  options.gnss_jumps = {{40.0, 50.0}};
  const Outcome outcome = drive_with(simulation::Drive(options), false, true);
  EXPECT_GT(outcome.refused, 3U);
  EXPECT_GT(outcome.with_gnss, outcome.scans - 120);
}

/// Five degrees are 550 km.
void throw_first(std::vector<GnssFix>& fixes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) fixes[i].latitude_deg += 5.0;
}

TEST(GnssTrack, DiscardsAFirstFixFarAway) {
  simulation::DriveOptions options;
  options.duration = 60.0;
  const simulation::Drive drive(options);
  for (const bool with_motion : {true, false}) {
    const Outcome outcome = drive_with(drive, with_motion, true, 0.0,
                                       [](std::vector<GnssFix>& fixes) { throw_first(fixes, 1); });
    EXPECT_LT(outcome.worst, 1.0);
    EXPECT_GE(outcome.with_gnss, outcome.scans - 6);
  }
}

TEST(GnssTrack, BeginsItsFrameAtTheNextFixesThatAgree) {
  simulation::DriveOptions options;
  options.duration = 20.0;
  const simulation::Drive drive(options);
  auto fixes = drive.gnss();
  throw_first(fixes, 1);
  Preprocessor stage({}, [](const std::string&) { return Pose::Identity(); });
  std::vector<SyncedScan> scans;
  std::size_t g = 0;
  for (std::size_t k = 0; k < drive.scan_count(); ++k) {
    const Stamp stamp = drive.scan_stamp(k);
    for (; g < fixes.size() && fixes[g].stamp <= stamp; ++g) stage.add_gnss(fixes[g], "gps");
    EXPECT_EQ(g == 1 && stage.datum(), false) << "of a fix that nothing confirms";
    test::append(scans, stage.process(test::ring_scan(stamp)));
  }
  test::append(scans, stage.flush());
  ASSERT_TRUE(stage.datum());
  EXPECT_EQ(stage.datum()->latitude_deg, fixes[1].latitude_deg);
  std::size_t with_gnss = 0;
  for (const SyncedScan& scan : scans) {
    if (!scan.gnss) continue;
    ++with_gnss;
    EXPECT_LT(scan.gnss->p_enu_antenna.norm(), 1000.0);
  }
  EXPECT_GE(with_gnss, scans.size() - 6);
  const std::string said = test::messages_of(stage);
  EXPECT_NE(said.find("gnss: the first fix is 556 km from the next ones"), std::string::npos)
      << said;
}

/// In the middle of a drive nobody knows which fixes are wrong; positions that were given stay.
TEST(GnssTrack, NeverAcceptsImpossibleJumps) {
  simulation::DriveOptions options;
  const simulation::Drive drive(options);
  const Outcome outcome = drive_with(drive, true, true, 0.0, [](std::vector<GnssFix>& fixes) {
    for (std::size_t i = fixes.size() / 2; i < fixes.size(); ++i) fixes[i].latitude_deg += 5.0;
  });
  EXPECT_LT(outcome.worst, 1.0);
  EXPECT_GT(outcome.refused, 10U);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
