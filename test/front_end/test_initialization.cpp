// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include "matched_sweeps.hpp"
#include "near.hpp"
#include "start/map_initialization.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::NeighborSearch;

constexpr std::size_t kScans = 25;
/// Scans in the earlier half, which are matched again. The first scan is never inserted here, so
/// that scans and insertions are not the same number.
constexpr std::size_t kEarlier = 13;

/// The first scans of a map that begins at the speed of a town, with few rings.
const std::vector<TrueSweep>& sweeps() {
  static const std::vector<TrueSweep> instance = [] {
    const simulation::Drive drive = make_drive("town", 14.0, 1, "vlp16");
    return true_sweeps(drive, 110, kScans);
  }();
  return instance;
}

LocalMap empty_map() { return {FrontEndConfig{}.voxel_size, FrontEndConfig{}.local_map_radius}; }
MotionFilter filter_at(const MotionState& state, const Matrix12d& covariance) {
  const FrontEndConfig config;
  MotionFilter filter(config.acceleration_sigma, config.angular_acceleration_sigma);
  filter.restart(state, covariance);
  return filter;
}
MotionFilter any_filter() { return filter_at({}, match_covariance(0.05, 0.005, 0.5, 0.05)); }

/// Points at random: they match nothing.
registration::NdtPoints points_from_elsewhere() {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> any(-15.0F, 15.0F);
  std::vector<float> x, y, z;
  for (int i = 0; i < 2000; ++i) {
    x.push_back(any(engine));
    y.push_back(any(engine));
    z.push_back(any(engine));
  }
  registration::NdtPoints points;
  points.assign(x, y, z, std::vector<float>(x.size(), 0.0F));
  return points;
}

double quality(const registration::NdtPoints& points, LocalMap& map, const MotionState& state) {
  return registration::NdtMatcher().evaluate(points, map.fine(), state, {}).quality;
}

// The first two scans of a map.

class SecondScan : public testing::Test {
 protected:
  const TrueSweep& first() const { return sweeps()[0]; }
  const TrueSweep& second() const { return sweeps()[second_]; }
  double seconds() const { return seconds_between(first(), second()); }

  /// As the tracker starts a map: the first scan is inserted as if the vehicle stood still.
  void start(bool have_times) {
    initialization_.start(kStart);
    initialization_.set_first_scan(first().dense, first().between_rings, have_times,
                                   first().sampler.reference());
    map_.insert(first().dense, initialization_.first_state(Vector6d::Zero()));
    map_.insert(first().between_rings, initialization_.first_state(Vector6d::Zero()));
  }
  /// Matched from rest, with any motion possible.
  SweepMatcher::Found match() {
    const FrontEndConfig config;
    MotionFilter filter(config.acceleration_sigma, config.angular_acceleration_sigma);
    filter.reset(kStart, 15.0, 1.0);
    filter.predict(first().sampler.reference());
    filter.predict(seconds());
    return initialization_.match_second_scan(second().sampler.points(), filter.belief(), seconds(),
                                             matcher_, map_);
  }
  MotionState from_start(MotionState state) const {
    state.T_map_sensor = kStart * state.T_map_sensor;
    return state;
  }

  const Pose kStart{exp_so3({0.0, 0.01, 0.8}), {30.0, -7.0, 1.0}};
  std::size_t second_ = 1;
  MapInitialization initialization_{NeighborSearch::kDirect1};
  SweepMatcher matcher_{NeighborSearch::kDirect1};
  LocalMap map_ = empty_map();
};

TEST_F(SecondScan, IsMatchedAtAnySpeed) {
  ASSERT_GT(second().truth.twist.head<3>().norm(), 5.0);
  start(true);
  const MotionState truth = from_start(second().truth);
  const SweepMatcher::Found found = match();
  EXPECT_TRUE(test::near(found.match.state.T_map_sensor, truth.T_map_sensor, 0.1, 0.01));
  EXPECT_TRUE(test::near(found.match.state.twist.head<3>(), truth.twist.head<3>(), 0.5));
  EXPECT_TRUE(found.degenerate_directions.empty());
}

// Up to fifteen scans were lost. The vehicle brakes and turns meanwhile, so that the first scan is
// deskewed with a twist that is a little wrong. Found is a pose within a voxel of the truth, from
// which the next scans converge; how near depends on the last bits of the simulated ranges, which
// processors compute differently.
TEST_F(SecondScan, IsFoundFarFromTheFirstOne) {
  for (const std::size_t second : {10U, 12U, 14U, 16U}) {
    second_ = second;
    map_ = empty_map();
    const MotionState truth = from_start(this->second().truth);
    ASSERT_GT((truth.T_map_sensor.translation - kStart.translation).norm(), 5.0);
    start(true);
    EXPECT_TRUE(test::near(match().match.state.T_map_sensor, truth.T_map_sensor, 1.0, 0.05))
        << second;
  }
}

TEST_F(SecondScan, LeavesTheFirstOneDeskewedInTheMap) {
  LocalMap deskewed = empty_map();
  deskewed.insert(first().dense, from_start(first().truth));
  deskewed.insert(first().between_rings, from_start(first().truth));
  const auto quality_in = [&](LocalMap& map) {
    return quality(first().sampler.points(), map, from_start(first().truth));
  };
  start(true);
  ASSERT_LT(quality_in(map_), quality_in(deskewed) - 0.05) << "or this test shows nothing";
  match();
  EXPECT_NEAR(quality_in(map_), quality_in(deskewed), 0.01);
  EXPECT_NEAR(static_cast<double>(map_.fine().size()), static_cast<double>(deskewed.fine().size()),
              0.02 * static_cast<double>(deskewed.fine().size()))
      << "the points between the rings are there too";
}

TEST_F(SecondScan, LeavesTheMapAloneIfThePointsHaveNoTimes) {
  start(false);
  const std::size_t voxels = map_.fine().size();
  const PointCloud before = map_.cloud();
  match();
  EXPECT_EQ(map_.fine().size(), voxels);
  const PointCloud after = map_.cloud();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    ASSERT_EQ(after.points[i].position(), before.points[i].position()) << i;
  }
}

TEST(MapInitialization, ReplacesTheFirstScanAtMostOncePerMap) {
  MapInitialization initialization(NeighborSearch::kDirect1);
  StepBelief safe;
  StepBelief unsafe;
  unsafe.safety = 0.1;
  StepBelief bearable;  // it would be doubtful behind a doubtful one
  bearable.safety = 0.8;
  EXPECT_FALSE(initialization.replaces_first_scan(safe));
  EXPECT_FALSE(initialization.replaces_first_scan(bearable));
  EXPECT_TRUE(initialization.replaces_first_scan(unsafe));
  EXPECT_FALSE(initialization.replaces_first_scan(unsafe)) << "once";
  initialization.set_motion({});
  EXPECT_TRUE(initialization.replaces_first_scan(unsafe)) << "the next map";
}

/// Whether the scans stay provisional after a second scan with this speed (m/s) and overlap.
bool is_provisional_after(double speed, double overlap) {
  MapInitialization initialization(NeighborSearch::kDirect1);
  initialization.start(Pose());
  initialization.add(sweeps()[0].stamp, sweeps()[0].sampler, any_filter());
  EXPECT_TRUE(initialization.is_provisional());
  registration::NdtMatch match;
  match.state.twist[1] = speed;
  match.overlap = overlap;
  initialization.set_motion(match);
  return initialization.is_provisional();
}

TEST(MapInitialization, LooksAgainOnlyAtFastStartsWithFewRings) {
  EXPECT_TRUE(is_provisional_after(10.0, 0.3));
  EXPECT_FALSE(is_provisional_after(1.0, 0.3)) << "a slow one";
  EXPECT_FALSE(is_provisional_after(10.0, 0.6)) << "the map of the first scan is good";
}

TEST(MapInitialization, RevisesTheEarlierScansAtTheirStamps) {
  MapInitialization initialization(NeighborSearch::kDirect1);
  const Pose start = sweeps()[0].truth.T_map_sensor;
  initialization.start(moved(start, sweeps()[0].truth.twist, -sweeps()[0].sampler.reference()));
  LocalMap map = empty_map();
  const MatchJudge judge(FrontEndConfig{}.max_speed);
  std::vector<Revision> revisions;
  const Matrix12d covariance = match_covariance(0.05, 0.005, 0.5, 0.05);
  for (std::size_t i = 0; i < kScans; ++i) {
    const MotionFilter filter = filter_at(sweeps()[i].truth, covariance);
    initialization.add(sweeps()[i].stamp, sweeps()[i].sampler, filter);
    if (i > 0) initialization.set_inserted(sweeps()[i].dense);
    if (i + 1 < kScans) {
      EXPECT_TRUE(initialization.rematch_first_scans(filter, judge, map).empty()) << i;
    }
  }
  for (int call = 0; call < 10 && initialization.is_provisional(); ++call) {
    EXPECT_TRUE(revisions.empty());
    revisions = initialization.rematch_first_scans(filter_at(sweeps().back().truth, covariance),
                                                   judge, map);
  }
  EXPECT_FALSE(initialization.is_provisional()) << "nothing is left to do";
  ASSERT_EQ(revisions.size(), kEarlier);
  for (std::size_t i = 0; i < kEarlier; ++i) {
    const TrueSweep& sweep = sweeps()[i];
    const Pose at_stamp =
        moved(sweep.truth.T_map_sensor, sweep.truth.twist, -sweep.sampler.reference());
    EXPECT_TRUE(test::near(revisions[i].T_odom_base, at_stamp, 0.08, 0.006)) << i;
    EXPECT_TRUE(test::near(revisions[i].twist.head<3>(), sweep.truth.twist.head<3>(), 0.7)) << i;
    EXPECT_TRUE(is_valid_covariance(revisions[i].covariance)) << i;
  }
}

TEST(MapInitialization, RevisesNothingOnceItIsFinal) {
  MapInitialization initialization(NeighborSearch::kDirect1);
  initialization.start(Pose());
  LocalMap map = empty_map();
  const MatchJudge judge(FrontEndConfig{}.max_speed);
  for (std::size_t i = 0; i < kScans; ++i) {
    initialization.add(sweeps()[i].stamp, sweeps()[i].sampler, any_filter());
    initialization.set_inserted(sweeps()[i].dense);
  }
  initialization.finalize();
  EXPECT_FALSE(initialization.is_provisional());
  for (int call = 0; call < 10; ++call) {
    EXPECT_TRUE(initialization.rematch_first_scans(any_filter(), judge, map).empty());
  }
  EXPECT_TRUE(map.empty());
}

// The second matching on its own.

/// A scan of the drive as it was matched first; `error` is that of the pose.
MatchedScan matched_scan(std::size_t i, const Vector6d& error = Vector6d::Zero()) {
  const TrueSweep& sweep = sweeps()[i];
  MatchedScan scan;
  scan.stamp = sweep.stamp;
  scan.reference = sweep.sampler.reference();
  scan.points = sweep.sampler.points();
  scan.state = sweep.truth;
  scan.state.T_map_sensor = perturbed(scan.state.T_map_sensor, error);
  scan.covariance = match_covariance(0.05, 0.005, 0.5, 0.05);
  return scan;
}

/// As the first match with a map of tilted planes leaves them: the earlier scans are wrong.
Vector6d first_error(std::size_t i) {
  Vector6d error = Vector6d::Zero();
  if (i < kEarlier) error << 0.1, 0.05, 0.1, 0.0, 0.01, 0.005;
  return error;
}

class Rematching : public testing::Test {
 protected:
  Rematching() { delayed_.start(); }

  void add(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      delayed_.add(matched_scan(i, first_error(i)));
      if (i > 0) delayed_.set_inserted(sweeps()[i].dense);
    }
  }
  bool rematch() { return delayed_.rematch(any_filter(), judge_, map_); }

  DelayedInitialization delayed_{NeighborSearch::kDirect1};
  MatchJudge judge_{FrontEndConfig{}.max_speed};
  LocalMap map_ = empty_map();
};

TEST_F(Rematching, WaitsForEnoughInsertions) {
  add(kScans - 1);
  EXPECT_FALSE(rematch());
  EXPECT_TRUE(map_.empty()) << "23 insertions are not enough";
  delayed_.add(matched_scan(kScans - 1));
  EXPECT_FALSE(rematch());
  EXPECT_TRUE(map_.empty()) << "a scan that is not inserted does not count";
  delayed_.set_inserted(sweeps().back().dense);
  EXPECT_FALSE(rematch());
  EXPECT_FALSE(map_.empty());
}

TEST_F(Rematching, BuildsTheMapFromTheLaterHalf) {
  add(kScans);
  map_.insert(sweeps()[0].dense, sweeps()[0].truth);
  rematch();
  LocalMap expected = empty_map();
  for (std::size_t i = kEarlier; i < kScans; ++i) {
    expected.insert(sweeps()[i].dense, sweeps()[i].truth);
  }
  EXPECT_EQ(map_.fine().size(), expected.fine().size());
}

TEST_F(Rematching, MatchesFourScansPerCall) {
  add(kScans);
  int calls = 1;
  while (!rematch() && calls < 20) ++calls;
  EXPECT_EQ(calls, 5) << "the first one only begins";
  EXPECT_EQ(delayed_.results().size(), kEarlier);
}

TEST_F(Rematching, CorrectsTheEarlierScans) {
  add(kScans);
  for (int call = 0; call < 20 && !rematch(); ++call) {
  }
  ASSERT_EQ(delayed_.results().size(), kEarlier);
  for (std::size_t i = 0; i < kEarlier; ++i) {
    const Pose& found = delayed_.results()[i].match.state.T_map_sensor;
    EXPECT_TRUE(test::near(found, sweeps()[i].truth.T_map_sensor, 0.08, 0.004)) << i;
  }
  LocalMap later_half = empty_map();
  for (std::size_t i = kEarlier; i < kScans; ++i) {
    later_half.insert(sweeps()[i].dense, sweeps()[i].truth);
  }
  EXPECT_GT(map_.fine().size(), later_half.fine().size() + 100) << "they are inserted again";
}

TEST_F(Rematching, GivesNoResultsIfAScanIsLost) {
  for (std::size_t i = 0; i < kScans; ++i) {
    MatchedScan scan = matched_scan(i);
    if (i == kEarlier - 6) scan.points = points_from_elsewhere();
    delayed_.add(scan);
    if (i > 0) delayed_.set_inserted(sweeps()[i].dense);
  }
  EXPECT_FALSE(rematch());
  EXPECT_FALSE(rematch()) << "the first four are found";
  EXPECT_TRUE(rematch());
  EXPECT_TRUE(delayed_.results().empty());
}

TEST_F(Rematching, TakesNoMoreScansOnceItHasBegun) {
  add(kScans);
  rematch();
  delayed_.add(matched_scan(0));
  delayed_.set_inserted(sweeps()[0].dense);
  EXPECT_EQ(delayed_.scans().size(), kScans);
}

TEST_F(Rematching, GivesUpASlowVehicleAfterSixSeconds) {
  for (const double seconds : {0.0, 1.0, 2.0, 5.9}) {
    MatchedScan scan = matched_scan(0);
    scan.stamp += from_seconds(seconds);
    delayed_.add(scan);
    delayed_.set_inserted(sweeps()[0].dense);
    EXPECT_FALSE(rematch()) << seconds;
  }
  MatchedScan late = matched_scan(0);
  late.stamp += from_seconds(6.1);
  delayed_.add(late);
  EXPECT_TRUE(rematch()) << "four insertions cannot improve the map";
  EXPECT_TRUE(delayed_.results().empty());
  EXPECT_TRUE(map_.empty());
}

// Tracking was lost while scans were matched again; the next map has too few scans for that.
TEST_F(Rematching, BeginsAgainAfterItWasInterrupted) {
  add(kScans);
  EXPECT_FALSE(rematch());
  EXPECT_FALSE(rematch()) << "some scans remain";
  delayed_.start();
  delayed_.add(matched_scan(0));
  delayed_.set_inserted(sweeps()[0].dense);
  EXPECT_FALSE(rematch());
  MatchedScan late = matched_scan(0);
  late.stamp += from_seconds(6.1);
  delayed_.add(late);
  EXPECT_TRUE(rematch()) << "none of the map before";
  EXPECT_TRUE(delayed_.results().empty());
}

TEST(DelayedInitialization, StoresNothingUnlessStarted) {
  DelayedInitialization delayed(NeighborSearch::kDirect1);
  EXPECT_FALSE(delayed.is_active());
  delayed.add(matched_scan(0));
  EXPECT_TRUE(delayed.scans().empty());
  delayed.start();
  EXPECT_TRUE(delayed.is_active());
  delayed.add(matched_scan(0));
  ASSERT_EQ(delayed.scans().size(), 1U);
  delayed.set_first_state(sweeps()[3].truth);
  EXPECT_TRUE(test::near(delayed.scans().front().state.T_map_sensor, sweeps()[3].truth.T_map_sensor,
                         1e-12));
  delayed.stop();
  EXPECT_FALSE(delayed.is_active());
  EXPECT_TRUE(delayed.scans().empty());
}

}  // namespace
}  // namespace lidar_mapping::front_end
