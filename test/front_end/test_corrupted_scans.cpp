// SPDX-License-Identifier: BSD-3-Clause
// Scans that are not what the sensor measured: they may reduce the accuracy, but no step that is
// wrong is called tracking.

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/prior_of.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

#include "campaign_imu.hpp"
#include "evaluated_drive.hpp"
#include "judgement/match_judge.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kAtSpeed = 90;
constexpr double kWrong = 0.3;  // m
constexpr double kEnd = 14.5;   // s: 50 scans after the first one

simulation::Drive corrupted_drive(const std::string& fault, const std::string& lidar,
                                  double duration, std::uint64_t seed = 51) {
  return faulty_drive(drive_options("town", duration, seed, lidar), fault);
}

struct Outcome {
  int silent = 0;  ///< steps that are wrong though called tracking
  int lost = 0;
  int repeated = 0;
  double error = 0.0;  ///< m, at the end
  double way = 0.0;
};

/// Rides from scan `first` on; `process` gives the number of a scan to the front end.
template <typename Process>
Outcome ride_through(const simulation::Drive& drive, std::size_t first, const Process& process) {
  EvaluatedDrive ride(drive);
  Outcome outcome;
  for (std::size_t i = first; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = process(ride, i);
    const bool is_lost = result.status.state == TrackingState::kLost;
    outcome.lost += is_lost ? 1 : 0;
    outcome.repeated += result.status.repeated ? 1 : 0;
    EXPECT_FALSE(is_lost && result.key_frame) << i;
    const bool wrong = ride.step_error().translation.norm() > kWrong;
    if (i > first && wrong && result.status.state == TrackingState::kTracking) ++outcome.silent;
    if (!is_lost) ride.end_step();
  }
  outcome.error = ride.error();
  outcome.way = ride.distance_travelled();
  return outcome;
}

Outcome ride_through(const simulation::Drive& drive, std::size_t first = kAtSpeed) {
  return ride_through(drive, first,
                      [](EvaluatedDrive& ride, std::size_t i) { return ride.process(i); });
}

/// With an IMU, whose measured motion preprocessing removes from the scans.
Outcome ride_with_imu(const simulation::Drive& drive) {
  campaign::ImuFeed scans(drive);
  return ride_through(drive, kAtSpeed, [&](EvaluatedDrive& ride, std::size_t i) {
    const preprocessing::SyncedScan synced = scans.next(i).value();
    return ride.process(synced.scan, prior_of(synced.imu, synced.velocity, synced.uneven_turning,
                                              synced.felt, synced.fingerprint));
  });
}

struct Case {
  const char* lidar;
  const char* fault;
  double drift;  ///< fraction of the distance travelled
};

class Outliers : public testing::TestWithParam<Case> {};

TEST_P(Outliers, IncreaseTheErrorByALimitedAmount) {
  const Outcome outcome = ride_through(corrupted_drive(GetParam().fault, GetParam().lidar, kEnd));
  EXPECT_EQ(outcome.silent, 0);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.error, GetParam().drift * outcome.way);
}

INSTANTIATE_TEST_SUITE_P(Drives, Outliers,
                         testing::Values(Case{"hdl64", "outliers=0.3", 0.003},
                                         Case{"vlp16", "outliers=0.3", 0.006}));

// Its side fills half of the view and moves along: to the match it is a wall that stands still
// beside the sensor. Where it counted as one, the end was off by 0.21 %.
TEST(Truck, AlongsideDoesNotCarryThePoseAway) {
  const Outcome outcome = ride_through(corrupted_drive("wall", "mid360", kEnd), 0);
  EXPECT_EQ(outcome.silent, 0);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.error, 0.001 * outcome.way);
}

struct SparseCase {
  const char* lidar;
  double drift;  ///< fraction of the distance travelled
};

class FewPoints : public testing::TestWithParam<SparseCase> {};

// So few points fill the voxels only if more of the scans enter the map, and all of their points.
// Before that, twelve such drives were off by 0.4 to 32 % of their way and lost 25 scans. Now the
// end is off by 0.8 % of it with 64 beams and by 1.8 % with 16, the median of five seeds, and a
// drive may lose a scan. One of the three may be worse.
TEST_P(FewPoints, AreEnoughToFollowAStreet) {
  std::vector<double> drifts;
  for (std::uint64_t seed = 51; seed <= 53; ++seed) {
    const simulation::Drive drive = corrupted_drive("sparse=500", GetParam().lidar, kEnd, seed);
    const Outcome outcome = ride_through(drive, 0);
    EXPECT_EQ(outcome.silent, 0) << seed;
    EXPECT_LE(outcome.lost, 1) << seed;
    drifts.push_back(outcome.error / outcome.way);
  }
  std::sort(drifts.begin(), drifts.end());
  EXPECT_LT(drifts[1], GetParam().drift) << testing::PrintToString(drifts);
}

INSTANTIATE_TEST_SUITE_P(Town, FewPoints,
                         testing::Values(SparseCase{"hdl64", 0.015}, SparseCase{"vlp16", 0.03}));

// The pose of a scan that comes again would be that of the last one, 1 m behind per scan.
TEST(RepeatedScan, IsReportedAsLostAndTheDriveContinues) {
  for (const auto& [fault, at_least] : {std::pair("frozen=1,2", 2), std::pair("frozen=4,2", 8)}) {
    const Outcome outcome = ride_through(corrupted_drive(fault, "vlp16", kEnd));
    EXPECT_GE(outcome.repeated, at_least) << fault;
    EXPECT_EQ(outcome.lost, outcome.repeated) << fault;
    EXPECT_EQ(outcome.silent, 0) << fault;
    EXPECT_LT(outcome.error, 0.02 * outcome.way) << fault;
  }
}

// Preprocessing moves the same points to other places each time; they were matched as new ones.
TEST(RepeatedScan, IsReportedWithAnImu) {
  for (const char* name : {"town", "walk"}) {
    const simulation::Drive drive =
        faulty_drive(drive_options(name, kEnd, 51, "vlp16"), "frozen=4,2");
    const Outcome outcome = ride_with_imu(drive);
    EXPECT_GE(outcome.repeated, 8) << name;
    EXPECT_EQ(outcome.lost, outcome.repeated) << name;
    EXPECT_EQ(outcome.silent, 0) << name;
  }
}

// The vehicle stands still here.
TEST(RepeatedScan, IsNotReportedAsTrackingByOtherMethods) {
  const simulation::Drive drive = corrupted_drive("frozen=2,1", "vlp16", 4.0);
  FrontEndConfig config;
  config.registration.method = registration::Method::kVgicp;
  FrontEnd front_end(config);
  for (std::size_t i = 0; i < 16; ++i) {
    const FrontEndStatus status = front_end.process(drive.base_scan(i)).status;
    const bool is_repeated = i == 11 || i == 12;
    EXPECT_EQ(status.repeated, is_repeated) << i;
    EXPECT_EQ(status.state == TrackingState::kDegraded, is_repeated) << i;
  }
}

// Over the time between two stamps the vehicle moves by 14 m/s times their error, 0.3 m.
TEST(StampJitter, HasLittleInfluenceOnPoses) {
  const simulation::Drive drive = corrupted_drive("jitter=0.02", "vlp16", kEnd);
  EvaluatedDrive ride(drive);
  constexpr std::size_t kFirst = 70;
  constexpr std::size_t kNoticed = kFirst + 25;
  double largest = 0.0;
  Pose T_map_last, T_odom_last;
  for (std::size_t i = kFirst; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = ride.process(i);
    const Pose T_map_base = drive.trajectory().pose(drive.scan_stamp(i));
    const Pose error = (T_map_last.inverse() * T_map_base).inverse() *
                       (T_odom_last.inverse() * result.T_odom_base);
    if (i > kNoticed) {
      largest = std::max(largest, error.translation.norm());
      EXPECT_NEAR(result.status.stamp_jitter, 0.02, 0.008) << i;
      EXPECT_EQ(result.status.state, TrackingState::kTracking) << i;
    }
    T_map_last = T_map_base;
    T_odom_last = result.T_odom_base;
  }
  EXPECT_LT(largest, 0.05);
}

TEST(MatchJudge, RejectsImpossibleMotions) {
  const MatchJudge judge(50.0);
  const auto step = [](double metres, double radians) {
    return Pose{exp_so3({0.0, 0.0, radians}), {metres, 0.0, 0.0}};
  };
  EXPECT_TRUE(judge.is_possible_motion(step(4.9, 0.0), 0.1));
  EXPECT_FALSE(judge.is_possible_motion(step(5.1, 0.0), 0.1));
  EXPECT_TRUE(judge.is_possible_motion(step(0.0, 1.2), 0.1));
  EXPECT_FALSE(judge.is_possible_motion(step(0.0, 1.3), 0.1));
  EXPECT_TRUE(judge.is_possible_motion(step(10.0, 2.0), 0.5));
}

}  // namespace
}  // namespace lidar_mapping::front_end
