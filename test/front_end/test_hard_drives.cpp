// Drives on which an odometry comes to grief: hand-held, without features, with sensors that lie.

#include <algorithm>
#include <random>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::front_end {
namespace {

simulation::Drive make_drive(const std::string& name, double duration, std::uint64_t seed = 1,
                             const std::string& lidar = "vlp16") {
  simulation::DriveOptions options;
  options.drive = name;
  options.lidar = lidar;
  options.seed = seed;
  options.duration = duration;
  return simulation::Drive(options);
}

/// Runs the front end over a drive and compares each result with the truth.
class Ride {
 public:
  explicit Ride(const simulation::Drive& drive) : drive_(drive) {
    front_end_.set_sensor_origin(drive.mounting().T_base_lidar.translation);
  }

  const FrontEndResult& take(std::size_t index, const MotionPrior& prior = {}) {
    return take(drive_.base_scan(index), prior);
  }

  const FrontEndResult& take(const Scan& scan, const MotionPrior& prior = {}) {
    const Pose T_map_base = drive_.trajectory().pose(scan.stamp);
    if (!begin_)
      begin_ = T_map_base;
    else
      way_ += (T_map_base.translation - T_map_last_.translation).norm();
    T_map_last_ = T_map_base;
    result_ = front_end_.process(scan, prior);
    return result_;
  }

  /// Distance (m) from where the sensor really is.
  double error() const {
    const Pose truth = begin_->inverse() * T_map_last_;
    return (truth.translation - (T_odom_begin_.inverse() * result_.T_odom_base).translation).norm();
  }
  double way() const { return way_; }
  /// Both are counted from here on.
  void begin_anew() {
    begin_ = T_map_last_;
    T_odom_begin_ = result_.T_odom_base;
    way_ = 0.0;
  }

 private:
  const simulation::Drive& drive_;
  FrontEnd front_end_{FrontEndConfig{}};
  FrontEndResult result_;
  std::optional<Pose> begin_;
  Pose T_odom_begin_;
  Pose T_map_last_;
  double way_ = 0.0;
};

/// The vehicle's velocity as a wheel sensor with a wrong radius and noise measures it.
MotionPrior wheel_speed(const simulation::Drive& drive, Stamp stamp, double scale, double noise,
                        std::mt19937& engine) {
  const simulation::MotionState state = drive.trajectory().state(stamp);
  std::normal_distribution<double> normal(0.0, noise);
  MotionPrior prior;
  prior.linear_velocity = scale * (state.T_map_base.rotation.conjugate() * state.velocity_map);
  for (double& component : *prior.linear_velocity) component += normal(engine);
  return prior;
}

struct Walk {
  const char* lidar;
  std::uint64_t seed;
  bool gyro;
};

class HandHeld : public testing::TestWithParam<Walk> {};

// Corridors and rooms, turns of 1.5 rad/s, two scans a second: a step of the way, a tenth of it
// seen.
TEST_P(HandHeld, IsTrackedAtTwoScansASecond) {
  const simulation::Drive drive = make_drive("walk", 60.0, GetParam().seed, GetParam().lidar);
  Ride ride(drive);
  for (std::size_t i = 0; i < drive.scan_count(); i += 5) {
    MotionPrior prior;
    if (GetParam().gyro) {
      prior.angular_velocity = drive.trajectory().state(drive.scan_stamp(i)).angular_velocity_base;
    }
    const FrontEndResult& result = ride.take(i, prior);
    if (result.status.state != TrackingState::kLost) {
      ASSERT_LT(ride.error(), 0.6 + 0.005 * ride.way()) << i;
    }
  }
  EXPECT_LT(ride.error(), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Walks, HandHeld,
                         testing::Values(Walk{"vlp16", 1, false}, Walk{"vlp16", 3, true},
                                         Walk{"os1_64", 1, false}));

// One scan of 16 rings makes too thin a fine map for a second one many metres further on. The
// coarse match that takes its place begins where the search has led, not at rest. In the last two
// drives the vehicle turns.
TEST(FewRings, AreFollowedFromTheFirstMetreOnAtTwoScansASecond) {
  for (const auto& [seed, first] :
       {std::pair{51U, 470U}, std::pair{51U, 230U}, std::pair{52U, 270U}, std::pair{53U, 470U},
        std::pair{1U, 230U}}) {
    const simulation::Drive drive = make_drive("town", 60.0, seed);
    Ride ride(drive);
    for (std::size_t i = first; i < first + 40U; i += 5) ride.take(i);
    EXPECT_GT(ride.way(), 15.0) << seed;
    EXPECT_LT(ride.error(), 0.5) << seed;
  }
}

// From rest the map stays that of one place for two metres; a sixth of the points find a plane in
// its fine voxels. Matched with those alone the first drive slid sideways by 1.3 m.
TEST(FewRings, DoNotSlideAsTheyStartFromRest) {
  for (const std::uint64_t seed : {66, 69}) {
    const simulation::Drive drive = make_drive("car_park", 14.0, seed);
    Ride ride(drive);
    for (std::size_t i = 0; i < drive.scan_count(); ++i) ride.take(i);
    EXPECT_GT(ride.way(), 30.0) << seed;
    EXPECT_LT(ride.error(), 0.3) << seed;
  }
}

// On top of a ramp the floor of the new storey lies 0.25 m above the ceiling of the one below. It
// is not to be taken for it. Where the map begins decides now and then; three starts of four must
// keep the height, of which one did when both sides of the slab shared their planes.
TEST(CarPark, KeepsItsHeightOnARamp) {
  constexpr std::size_t kBeforeTheRamp = 400, kBehindIt = 620;
  const simulation::Drive drive = make_drive("car_park", 64.0, 65);
  std::vector<double> errors;
  for (const std::size_t inside : {140, 145, 150, 155}) {
    Ride ride(drive);
    for (std::size_t i = inside; i < kBehindIt; ++i) {
      ride.take(i);
      if (i == kBeforeTheRamp) ride.begin_anew();
    }
    errors.push_back(ride.error());
  }
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

// Nothing in a smooth tunnel says how fast the sensor goes: it is to go on as it came in, through
// bends as well, and to come out where the tunnel ends.
TEST_P(BlindTunnel, IsPassedAtTheSpeedOfItsBeginning) {
  const simulation::Drive drive = make_drive("tunnel", 42.0, GetParam().seed, GetParam().lidar);
  Ride ride(drive);
  int degenerate = 0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = ride.take(i);
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    degenerate += result.status.state == TrackingState::kDegenerate ? 1 : 0;
    if (i == kBeforeTheTunnel) ride.begin_anew();
  }
  EXPECT_GT(degenerate, 60);
  EXPECT_LT(ride.error(), 0.008 * ride.way());
}

INSTANTIATE_TEST_SUITE_P(Tunnels, BlindTunnel,
                         testing::Values(SensorAndSeed{"vlp16", 1}, SensorAndSeed{"vlp16", 2},
                                         SensorAndSeed{"os1_64", 3}));

// A wheel radius that is off by 1.5 % is found out before the tunnel and corrected inside.
TEST(Tunnel, IsPassedWithANoisyWheelSpeedOfWrongScale) {
  const simulation::Drive drive = make_drive("tunnel", 36.0);
  std::mt19937 engine(4);
  Ride ride(drive);
  int degenerate = 0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const FrontEndResult& result =
        ride.take(i, wheel_speed(drive, drive.scan_stamp(i), 1.015, 0.1, engine));
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    degenerate += result.status.degenerate_directions.empty() ? 0 : 1;
  }
  EXPECT_GT(degenerate, 60);
  EXPECT_LT(ride.error(), 0.005 * ride.way());
}

/// Mean of squared errors in units of their covariance, per degree of freedom.
class NormalisedError {
 public:
  void add(const Pose& motion, const Pose& true_motion, const Covariance6& covariance) {
    const Vector6d error = difference(true_motion, motion);
    sum_ += error.dot(covariance.ldlt().solve(error)) / 6.0;
    ++count_;
  }
  double mean() const { return sum_ / count_; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

class SizeOfCovariance : public testing::TestWithParam<const char*> {};

// The back end weighs the way from key frame to key frame with it. Smooth walls, rough fields and a
// person's gait differ in how well the points fit, and in how fast errors part.
TEST_P(SizeOfCovariance, IsThatOfTheErrors) {
  const simulation::Drive drive = make_drive(GetParam(), 45.0);
  FrontEnd front_end{FrontEndConfig{}};
  front_end.set_sensor_origin(drive.mounting().T_base_lidar.translation);
  NormalisedError of_scans;
  NormalisedError of_key_frames;
  std::optional<FrontEndResult> last;
  std::optional<KeyFrame> last_key_frame;
  const auto way = [&](Stamp from, Stamp to) {
    return drive.trajectory().pose(from).inverse() * drive.trajectory().pose(to);
  };
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const FrontEndResult result = front_end.process(drive.base_scan(i));
    if (last) {
      of_scans.add(last->T_odom_base.inverse() * result.T_odom_base, way(last->stamp, result.stamp),
                   result.covariance);
    }
    last = result;
    if (!result.key_frame) continue;
    if (last_key_frame) {
      of_key_frames.add(last_key_frame->T_odom_base.inverse() * result.T_odom_base,
                        way(last_key_frame->stamp, result.stamp),
                        result.key_frame->motion_covariance);
    }
    last_key_frame = result.key_frame;
  }
  EXPECT_GT(of_scans.mean(), 0.5);
  EXPECT_LT(of_scans.mean(), 2.0);
  EXPECT_GT(of_key_frames.mean(), 0.5);
  EXPECT_LT(of_key_frames.mean(), 2.0);
}

INSTANTIATE_TEST_SUITE_P(Drives, SizeOfCovariance,
                         testing::Values("town", "figure_eight", "car_park", "tunnel", "open_road",
                                         "walk"));

// Beyond 30 m a voxel in a tree is crossed by one ring at a time, which goes along with the sensor.
TEST(TownWithFewRings, IsNotBentByItsTrees) {
  constexpr std::size_t kBegin = 100;
  const simulation::Drive drive = make_drive("town", 80.0, 14);
  Ride ride(drive);
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    ASSERT_NE(ride.take(i).status.state, TrackingState::kLost) << i;
    if (i == kBegin) ride.begin_anew();
  }
  EXPECT_LT(ride.error(), 0.2) << "0.35 where rings on leaves pull upwards";
}

class StartAtSpeed : public testing::TestWithParam<std::uint64_t> {};

/// The first key frames of a drive with few rings that begins at this scan.
std::vector<KeyFrame> first_key_frames(const simulation::Drive& drive, std::size_t begin,
                                       std::size_t count) {
  FrontEnd front_end{FrontEndConfig{}};
  front_end.set_sensor_origin(drive.mounting().T_base_lidar.translation);
  std::vector<KeyFrame> key_frames;
  const auto take = [&](const FrontEndResult& result) {
    if (result.key_frame) key_frames.push_back(*result.key_frame);
  };
  for (std::size_t i = begin; key_frames.size() < count; ++i) {
    const FrontEndResult result = front_end.process(drive.base_scan(i));
    for (const FrontEndResult& settled : result.settled) take(settled);
    take(result);
  }
  key_frames.resize(count);
  return key_frames;
}

// The map of one scan leans where there are few rings. Drives that are joined lean on their ends.
TEST_P(StartAtSpeed, HasKeyFramesAsGoodAsOthers) {
  const simulation::Drive drive = make_drive("town", 22.0, GetParam(), "vlp16");
  const std::vector<KeyFrame> key_frames = first_key_frames(drive, 110, 12);
  const auto true_way = [&](const KeyFrame& from, const KeyFrame& to) {
    return drive.trajectory().pose(from.stamp).inverse() * drive.trajectory().pose(to.stamp);
  };
  const auto way = [](const KeyFrame& from, const KeyFrame& to) {
    return from.T_odom_base.inverse() * to.T_odom_base;
  };
  NormalisedError error;
  for (std::size_t k = 1; k < key_frames.size(); ++k) {
    const KeyFrame& from = key_frames[k - 1];
    const KeyFrame& to = key_frames[k];
    error.add(way(from, to), true_way(from, to), to.motion_covariance);
  }
  const KeyFrame& first = key_frames.front();
  const KeyFrame& last = key_frames.back();
  const Vector6d slip = difference(true_way(last, first), way(last, first));
  EXPECT_LT(error.mean(), 6.0);
  EXPECT_LT(slip.head<3>().norm(), 0.02) << "0.022 to 0.036 without another look";
  EXPECT_LT(slip.tail<3>().norm() * 180.0 / M_PI, 0.1) << "0.18 to 0.32 without it";
}

INSTANTIATE_TEST_SUITE_P(Towns, StartAtSpeed, testing::Values(1, 2, 3));

// The vehicle brakes, stands at a crossing among other cars and starts off again.
TEST(StopAndGo, StandsStillWithoutDriftOrKeyFramesAndGoesOn) {
  constexpr double kStanding = 0.02;  // m/s
  constexpr std::size_t kBeforeTheStop = 300;
  const simulation::Drive drive = make_drive("town", 48.0);
  Ride ride(drive);
  int standing = 0;
  int key_frames = 0;
  for (std::size_t i = kBeforeTheStop; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = ride.take(i);
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    if (drive.trajectory().state(drive.scan_stamp(i)).velocity_map.norm() < kStanding) {
      if (standing++ == 0) ride.begin_anew();
      key_frames += result.key_frame ? 1 : 0;
      ASSERT_LT(ride.error(), 0.03) << i;
    } else if (standing > 0) {
      ASSERT_LT(ride.error(), 0.05 + 0.01 * ride.way()) << i;
    }
  }
  EXPECT_GT(standing, 10);
  EXPECT_LE(key_frames, 1);
  EXPECT_GT(ride.way(), 20.0);
}

// What the first scan showed is gone with the second one: waiting for it would lose the start.
TEST(FirstScanFromElsewhere, IsReplacedAtOnce) {
  constexpr std::size_t kElsewhere = 450;
  constexpr std::size_t kReplaced = 4;
  const simulation::Drive drive = make_drive("town", 50.0);
  Ride ride(drive);
  ride.take({drive.scan_stamp(300), drive.base_scan(kElsewhere).cloud});
  for (std::size_t i = 301; i < 320; ++i) {
    const FrontEndResult& result = ride.take(i);
    if (i < 300 + kReplaced) continue;
    EXPECT_EQ(result.status.state, TrackingState::kTracking) << i;
    if (i == 300 + kReplaced) ride.begin_anew();
  }
  EXPECT_LT(ride.error(), 0.1);
}

// Most of 64 beams meet the ground; the few posts and trees are little beside it, yet enough.
/// Turns on the spot from one scan to the next: more than anything before let expect.
TEST(TurnOnTheSpot, IsFollowedFromRest) {
  const simulation::Drive drive = make_drive("town", 4.0);
  const Scan standing = drive.base_scan(0);
  constexpr double kStep = 0.2;  // rad per scan
  FrontEnd front_end{FrontEndConfig{}};
  front_end.set_sensor_origin(drive.mounting().T_base_lidar.translation);
  for (int i = 0; i < 40; ++i) {
    const double yaw = std::max(0, i - 20) * kStep;
    const Pose T_map_base{exp_so3(yaw * Eigen::Vector3d::UnitZ()), Eigen::Vector3d::Zero()};
    Scan scan = standing;
    scan.stamp += i * from_seconds(0.1);
    scan.cloud = transformed(standing.cloud, T_map_base.inverse());
    scan.cloud.times.clear();
    const FrontEndResult result = front_end.process(scan);
    EXPECT_NE(result.status.state, TrackingState::kLost) << "scan " << i;
    const Vector6d error = difference(T_map_base, result.T_odom_base);
    EXPECT_LT(error.head<3>().norm(), 0.05) << "scan " << i;
    EXPECT_LT(error.tail<3>().norm(), 0.01) << "scan " << i;
  }
}

TEST(OpenField, IsNotBlindToARoadThatIsSpeededUpOn) {
  const simulation::Drive drive = make_drive("open_road", 50.0, 92, "hdl64");
  Ride ride(drive);
  for (std::size_t i = 360; i < 480; ++i) {
    ride.take(i);
    if (i == 370) ride.begin_anew();
  }
  EXPECT_GT(ride.way(), 100.0);
  EXPECT_LT(ride.error(), 0.005 * ride.way());
}

// Sixteen rings on rough ground, seen from one place, fit wherever the sensor goes: that it moves
// is noticed late or never. It must be said, and must not discredit a velocity that knows better.
TEST(OpenField, SaysThatTheStartMayGoUnnoticed) {
  constexpr double kStep = 0.1;  // m
  for (const std::uint64_t seed : {42, 46}) {
    const simulation::Drive drive = make_drive("open_road", 16.0, seed);
    Ride alone(drive), with_velocity(drive);
    std::mt19937 engine(5);
    int silent = 0;
    for (std::size_t i = 0; i < drive.scan_count(); ++i) {
      const double before = i > 0 ? alone.error() : 0.0;
      const bool said = alone.take(i).status.state != TrackingState::kTracking;
      if (!said && alone.error() > before + kStep) ++silent;
      with_velocity.take(i, wheel_speed(drive, drive.scan_stamp(i), 1.01, 0.05, engine));
    }
    EXPECT_LE(silent, 5) << seed;
    EXPECT_LT(with_velocity.error(), 0.08 * with_velocity.way()) << seed;
  }
}

/// A start from rest on a road through fields.
simulation::Drive make_start(std::uint64_t seed, bool undistorted, double range_noise) {
  simulation::DriveOptions options;
  options.drive = "open_road";
  options.lidar = "vlp16";
  options.seed = seed;
  options.duration = 16.0;
  options.undistorted = undistorted;
  options.range_noise = range_noise;
  return simulation::Drive(options);
}

// As the vehicle rolls off, ever fewer of the points find a plane of the map that was made at rest,
// in the coarse one, too. That is no reason to take the fine one, in which next to none does.
TEST(OpenField, IsFollowedFromRest) {
  for (const auto& [seed, undistorted] :
       {std::pair{44U, false}, std::pair{45U, true}, std::pair{46U, false}, std::pair{48U, true}}) {
    const simulation::Drive drive = make_start(seed, undistorted, 0.02);
    Ride ride(drive);
    for (std::size_t i = 0; i < drive.scan_count(); ++i) ride.take(i);
    EXPECT_LT(ride.error(), 0.06 * ride.way()) << seed;
  }
}

// The rings go with the sensor, and all that stays behind are some trees and posts. Without them
// all these stand still for good.
TEST(OpenField, IsFollowedFromRestByWhatStandsUpright) {
  for (const auto& [seed, undistorted, range_noise] :
       {std::tuple{41U, false, 0.02}, std::tuple{57U, false, 0.02}, std::tuple{68U, true, 0.02},
        std::tuple{67U, false, 0.05}}) {
    const simulation::Drive drive = make_start(seed, undistorted, range_noise);
    Ride ride(drive);
    for (std::size_t i = 0; i < drive.scan_count(); ++i) ride.take(i);
    EXPECT_LT(ride.error(), 0.06 * ride.way()) << seed;
  }
}

TEST(VelocityThatLies, IsFoundOut) {
  const simulation::Drive drive = make_drive("town", 16.0);
  for (const double scale : {0.0, 1.3}) {
    std::mt19937 engine(4);
    Ride ride(drive);
    for (std::size_t i = 0; i < drive.scan_count(); ++i) {
      ride.take(i, wheel_speed(drive, drive.scan_stamp(i), scale, 0.0, engine));
      ASSERT_LT(ride.error(), 0.05 + 0.003 * ride.way()) << scale << " " << i;
    }
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
