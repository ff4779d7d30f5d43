// SPDX-License-Identifier: BSD-3-Clause
// Drives that are difficult for an odometry: hand-held, without features, with wrong sensors.

#include <algorithm>
#include <array>
#include <deque>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "evaluated_drive.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Sensors of a walk: without and with a gyro, or without one alone.
struct Walk {
  const char* lidar;
  std::vector<bool> gyros;
};

constexpr std::size_t kEveryFifth = 5;
constexpr double kMostOfAWalk = 0.6;  ///< m, and 5 mm per metre of way

/// A walk, until some scan that was not called lost is further off than that.
class WalkedDrive {
 public:
  WalkedDrive(const simulation::Drive& drive, bool gyro)
      : drive_(drive), ride_(drive), gyro_(gyro) {}

  void process(const Scan& scan) {
    if (left_) return;
    MotionPrior prior;
    if (gyro_) prior.angular_velocity = drive_.trajectory().state(scan.stamp).angular_velocity_base;
    const FrontEndResult& result = ride_.process(scan, prior);
    left_ = result.status.state != TrackingState::kLost &&
            ride_.error() >= kMostOfAWalk + 0.005 * ride_.distance_travelled();
  }
  /// Whether it left its way, or ended elsewhere.
  bool has_left() const { return left_ || ride_.error() >= 0.5; }

 private:
  const simulation::Drive& drive_;
  EvaluatedDrive ride_;
  bool gyro_;
  bool left_ = false;
};

class HandHeld : public testing::TestWithParam<Walk> {};

// Corridors and rooms, turns of 1.5 rad/s, two scans a second: a step of the way, a tenth of it
// seen. One walk in twenty goes wrong with 16 beams, one in six with 64, and which one is a matter
// of the last bits of its scans. One of five may.
TEST_P(HandHeld, IsTrackedAtTwoScansASecond) {
  const Walk& walk = GetParam();
  std::vector<std::vector<std::uint64_t>> left(walk.gyros.size());
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const simulation::Drive drive = make_drive("walk", 60.0, seed, walk.lidar);
    std::deque<WalkedDrive> walks;
    for (const bool gyro : walk.gyros) walks.emplace_back(drive, gyro);
    for (std::size_t i = 0; i < drive.scan_count(); i += kEveryFifth) {
      const Scan scan = lidar_scan(drive, i);
      for (WalkedDrive& walked : walks) walked.process(scan);
    }
    for (std::size_t k = 0; k < walks.size(); ++k) {
      if (walks[k].has_left()) left[k].push_back(seed);
    }
  }
  for (const auto& seeds : left) EXPECT_LE(seeds.size(), 1U) << testing::PrintToString(seeds);
}

INSTANTIATE_TEST_SUITE_P(Walks, HandHeld,
                         testing::Values(Walk{"vlp16", {false, true}}, Walk{"os1_64", {false}}));

// On top of a ramp the floor of the new storey lies 0.25 m above the ceiling of the one below. It
// is not to be taken for it. Where the map begins decides now and then; three starts of four must
// keep the height, of which one did when both sides of the slab shared their planes.
TEST(CarPark, KeepsItsHeightOnARamp) {
  constexpr std::array<std::size_t, 4> kStarts = {140, 145, 150, 155};
  constexpr std::size_t kBeforeTheRamp = 400, kBehindIt = 620;
  const simulation::Drive drive = make_drive("car_park", 64.0, 65);
  std::deque<EvaluatedDrive> rides;
  for (std::size_t i = kStarts.front(); i < kBehindIt; ++i) {
    if (rides.size() < kStarts.size() && i == kStarts[rides.size()]) rides.emplace_back(drive);
    const Scan scan = lidar_scan(drive, i);
    for (EvaluatedDrive& ride : rides) {
      ride.process(scan);
      if (i == kBeforeTheRamp) ride.restart_evaluation();
    }
  }
  std::vector<double> errors;
  for (const EvaluatedDrive& ride : rides) errors.push_back(ride.error());
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[2], 0.1) << testing::PrintToString(errors);
}

struct SensorAndSeed {
  const char* lidar;
  std::uint64_t seed;
};

/// The portal is passed at 17.5 s.
constexpr std::size_t kBeforeTheTunnel = 165;

class BlindTunnel : public testing::TestWithParam<SensorAndSeed> {};

// Nothing in a smooth tunnel shows how fast the sensor moves. The odometry has to go on with the
// speed at the entry, through bends as well, and to come out where the tunnel ends.
TEST_P(BlindTunnel, IsPassedAtTheEntrySpeed) {
  const simulation::Drive drive = make_drive("tunnel", 42.0, GetParam().seed, GetParam().lidar);
  EvaluatedDrive ride(drive);
  int degenerate = 0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = ride.process(i);
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    degenerate += result.status.state == TrackingState::kDegenerate ? 1 : 0;
    if (i == kBeforeTheTunnel) ride.restart_evaluation();
  }
  EXPECT_GT(degenerate, 60);
  EXPECT_LT(ride.error(), 0.008 * ride.distance_travelled());
}

INSTANTIATE_TEST_SUITE_P(Tunnels, BlindTunnel,
                         testing::Values(SensorAndSeed{"vlp16", 1}, SensorAndSeed{"vlp16", 2},
                                         SensorAndSeed{"os1_64", 3}));

// A wheel radius that is off by 1.5 % is learned before the tunnel and corrected inside.
TEST(Tunnel, IsPassedWithANoisyWheelSpeedOfWrongScale) {
  const simulation::Drive drive = make_drive("tunnel", 36.0);
  std::mt19937 engine(4);
  EvaluatedDrive ride(drive);
  int degenerate = 0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const FrontEndResult& result =
        ride.process(i, wheel_speed(drive, drive.scan_stamp(i), 1.015, 0.1, engine));
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    degenerate += result.status.degenerate_directions.empty() ? 0 : 1;
  }
  EXPECT_GT(degenerate, 50);
  EXPECT_LT(ride.error(), 0.005 * ride.distance_travelled());
}

// Beyond 30 m a voxel in a tree is crossed by one ring at a time, which goes along with the sensor.
TEST(TownWithFewRings, IsNotBentByItsTrees) {
  constexpr std::size_t kBegin = 100;
  const simulation::Drive drive = make_drive("town", 80.0, 14);
  EvaluatedDrive ride(drive);
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    ASSERT_NE(ride.process(i).status.state, TrackingState::kLost) << i;
    if (i == kBegin) ride.restart_evaluation();
  }
  EXPECT_LT(ride.error(), 0.2) << "0.35 where rings on leaves pull upwards";
}

// The vehicle brakes, stands at a crossing among other cars and starts off again.
TEST(StopAndGo, StandsStillWithoutDriftOrKeyFramesAndContinues) {
  constexpr double kStanding = 0.02;  // m/s
  constexpr std::size_t kBeforeTheStop = 300;
  const simulation::Drive drive = make_drive("town", 48.0);
  EvaluatedDrive ride(drive);
  int standing = 0;
  int key_frames = 0;
  for (std::size_t i = kBeforeTheStop; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = ride.process(i);
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    if (drive.trajectory().state(drive.scan_stamp(i)).velocity_map.norm() < kStanding) {
      if (standing++ == 0) ride.restart_evaluation();
      key_frames += result.key_frame ? 1 : 0;
      ASSERT_LT(ride.error(), 0.03) << i;
    } else if (standing > 0) {
      ASSERT_LT(ride.error(), 0.05 + 0.01 * ride.distance_travelled()) << i;
    }
  }
  EXPECT_GT(standing, 10);
  EXPECT_LE(key_frames, 1);
  EXPECT_GT(ride.distance_travelled(), 20.0);
}

TEST(WrongVelocity, IsDetected) {
  const simulation::Drive drive = make_drive("town", 16.0);
  for (const double scale : {0.0, 1.3}) {
    std::mt19937 engine(4);
    EvaluatedDrive ride(drive);
    for (std::size_t i = 0; i < drive.scan_count(); ++i) {
      ride.process(i, wheel_speed(drive, drive.scan_stamp(i), scale, 0.0, engine));
      ASSERT_LT(ride.error(), 0.05 + 0.003 * ride.distance_travelled()) << scale << " " << i;
    }
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
