// SPDX-License-Identifier: BSD-3-Clause
// The parts of the sequential NDT's tracker: its state, its judge, and what it inserts into its
// map.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "judgement/step_judge.hpp"
#include "judgement/step_origin.hpp"
#include "local_map/local_mapper.hpp"
#include "motion/coasting.hpp"
#include "motion/motion_predictor.hpp"
#include "tracking/tracker_state.hpp"

namespace lidar_mapping::front_end {
namespace {

Pose ahead(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

TrackedScan tracked_at(double x, TrackingState state) {
  TrackedScan tracked;
  tracked.T_odom_base = ahead(x);
  tracked.covariance = diagonal_covariance(0.1, 0.01);
  tracked.status.state = state;
  return tracked;
}

TEST(StepOrigin, StaysAtTheLastClaimedPose) {
  StepOrigin origin;
  const PoseEstimate here{ahead(3.0), diagonal_covariance(0.1, 0.01), 1.0};
  StepEvidence evidence;
  origin.update(tracked_at(1.0, TrackingState::kTracking));
  for (const auto state : {TrackingState::kLost, TrackingState::kDegraded}) {
    origin.advance(0.1);
    origin.update(tracked_at(2.0, state));
  }
  origin.advance(0.1);
  origin.set_step_to(here, evidence);
  EXPECT_NEAR(evidence.seconds, 0.3, 1e-12);
  const double sigma_of_long_step = evidence.sigma;
  origin.update(tracked_at(2.5, TrackingState::kDoubtful));
  origin.advance(0.1);
  origin.set_step_to(here, evidence);
  EXPECT_NEAR(evidence.seconds, 0.1, 1e-12);
  EXPECT_LT(evidence.sigma, sigma_of_long_step);
}

TEST(StepOrigin, IsTheFirstScanOfASegment) {
  StepOrigin origin;
  origin.advance(5.0);
  TrackedScan first = tracked_at(0.0, TrackingState::kLost);
  first.new_segment = true;
  origin.update(first);
  StepEvidence evidence;
  origin.set_step_to({}, evidence);
  EXPECT_EQ(evidence.seconds, 0.0);
}

// A driver that sends the same points again after an hour.
TEST(Coasted, GoesOnForSecondsOnly) {
  TrackedScan tracked = tracked_at(1.0, TrackingState::kTracking);
  tracked.twist[0] = 10.0;
  EXPECT_NEAR(coasted(tracked, 0.5).T_odom_base.translation.x(), 6.0, 1e-9);
  EXPECT_NEAR(coasted(tracked, 3600.0).T_odom_base.translation.x(), 51.0, 1e-9);
}

/// Points all around the sensor, at this distance (m).
Scan scan_of_walls(double range, int points = 4000) {
  Scan scan;
  for (int i = 0; i < points; ++i) {
    const double azimuth = 0.1 * i;
    const double z = 2.0 * i / points - 1.0;
    scan.cloud.points.push_back({static_cast<float>(range * std::cos(azimuth)),
                                 static_cast<float>(range * std::sin(azimuth)),
                                 static_cast<float>(z), 0.0F});
  }
  return scan;
}

MotionState moving(double x, double speed) {
  MotionState state{ahead(x), Vector6d::Zero()};
  state.twist[0] = speed;
  return state;
}

/// Inserts scans at poses of a tracker.
class Insertions {
 public:
  explicit Insertions(double range, int points = 4000) : scan_(scan_of_walls(range, points)) {
    config_.calibrate_elevation = false;
    sweep_.sample(scan_, 0);
    start_motion(Pose{}, 0.0, state_);
    mapper_.start_map(scan_, Pose{}, sweep_, state_.map);
  }

  /// True if the mapper inserts a scan at this position.
  bool insert_at(double x) {
    state_.filter.restart(moving(x, 0.0), Matrix12d::Identity());
    if (!mapper_.is_due(state_)) return false;
    mapper_.insert(scan_, sweep_, state_, timer_);
    return true;
  }
  TrackerState& state() { return state_; }
  const LocalMapper& mapper() const { return mapper_; }
  double voxel_size() const { return config_.voxel_size; }

 private:
  FrontEndConfig config_;
  Scan scan_;
  SweepSampler sweep_{config_};
  TrackerState state_{config_};
  LocalMapper mapper_{config_};
  StepTimer timer_;
};

TEST(SweepSampler, LeavesMarkedPointsOutUntilTheNextScan) {
  const Scan scan = scan_of_walls(20.0);
  SweepSampler sweep{FrontEndConfig{}};
  sweep.sample(scan, 0);
  const std::size_t all = sweep.points().size();
  EXPECT_FALSE(sweep.leaves_out_points());
  PointMarks marks(all, 0);
  marks[1] = marks[3] = 1;
  sweep.leave_out(marks);
  EXPECT_TRUE(sweep.leaves_out_points());
  EXPECT_EQ(sweep.points().size(), all - 2);
  EXPECT_EQ(sweep.sparse().size(), all - 2);
  const std::size_t dense = sweep.sample_dense(scan).size();
  marks.assign(dense, 1);
  marks[0] = 0;
  sweep.leave_out_of_dense(marks);
  EXPECT_EQ(sweep.sample_dense(scan).size(), dense) << "sampled anew";
  sweep.sample(scan, 0);
  EXPECT_FALSE(sweep.leaves_out_points());
  EXPECT_GE(sweep.points().size(), all);
}

/// A wall ahead of the sensor, 4 m wide and high, with a point every 0.2 m.
Scan scan_of_a_plate(double distance) {
  Scan scan;
  for (float y = -2.0F; y < 2.0F; y += 0.2F) {
    for (float z = -2.0F; z < 2.0F; z += 0.2F)
      scan.cloud.points.push_back({static_cast<float>(distance), y, z, 0.0F});
  }
  return scan;
}

// What stands where the scan before looked through moves: it does not enter the map. Only a scan
// of which such points were left out is tested for them.
TEST(LocalMapper, InsertsNoMovingPoints) {
  FrontEndConfig config;
  config.calibrate_elevation = false;
  const Scan far = scan_of_a_plate(20.0), near = scan_of_a_plate(8.0);
  for (const bool leaves_out : {false, true}) {
    SweepSampler sweep(config);
    TrackerState state(config);
    LocalMapper mapper(config);
    StepTimer timer;
    start_motion(Pose{}, 0.0, state);
    sweep.sample(far, 0);
    mapper.start_map(far, Pose{}, sweep, state.map);
    mapper.insert(far, sweep, state, timer);
    sweep.sample(near, 1);
    if (leaves_out) sweep.leave_out(PointMarks(sweep.points().size(), 1));
    const std::size_t inserted = mapper.insert(near, sweep, state, timer).size();
    EXPECT_EQ(inserted > 100, !leaves_out) << inserted;
  }
}

TEST(LocalMapper, InsertsTheFirstScansAndThenWhereTheSensorMoves) {
  Insertions insertions(20.0);
  EXPECT_TRUE(insertions.state().map.empty());
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(insertions.insert_at(0.0));
  EXPECT_FALSE(insertions.state().map.empty());
  EXPECT_FALSE(insertions.insert_at(0.0));
  EXPECT_FALSE(insertions.insert_at(1.9));
  EXPECT_TRUE(insertions.insert_at(2.1));
  EXPECT_FALSE(insertions.insert_at(2.1));
  EXPECT_EQ(insertions.state().coverage.inserted_scans, 4);
}

TEST(LocalMapper, InsertsScansOfFewPointsAfterAShorterMotion) {
  Insertions insertions(20.0, 1000);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(insertions.insert_at(0.0));
  EXPECT_FALSE(insertions.insert_at(0.45));
  EXPECT_TRUE(insertions.insert_at(0.55));
  EXPECT_TRUE(insertions.insert_at(1.1));
}

TEST(LocalMap, KeepsMoreOfFewPointsInItsCoarseVoxels) {
  FrontEndConfig config;
  SweepSampler sweep(config);
  const auto coarse_voxels = [&](double density) {
    LocalMap map(config.voxel_size, config.local_map_radius);
    map.set_scan_density(density);
    const Scan scan = scan_of_walls(20.0, 400);
    sweep.sample(scan, 0);
    map.insert(sweep.sample_dense(scan), {});
    return map.coarse().size();
  };
  EXPECT_GT(coarse_voxels(0.1), coarse_voxels(1.0));
}

TEST(LocalMapper, ReportsWhenTheMapCoversMoreThanOnePlace) {
  Insertions insertions(20.0);
  const double radius = 10.0 * insertions.voxel_size();
  EXPECT_TRUE(insertions.insert_at(0.9 * radius));
  EXPECT_TRUE(insertions.state().coverage.is_single_place);
  EXPECT_TRUE(insertions.insert_at(1.1 * radius));
  EXPECT_FALSE(insertions.state().coverage.is_single_place);
}

TEST(LocalMapper, UsesSmallVoxelsInRooms) {
  Insertions street(20.0, 100000);
  Insertions room(3.0, 100000);
  EXPECT_FALSE(street.mapper().is_indoors());
  EXPECT_TRUE(room.mapper().is_indoors());
  EXPECT_EQ(street.state().map.fine().resolution(), street.voxel_size());
  EXPECT_EQ(room.state().map.fine().resolution(), 0.5 * room.voxel_size());
}

// As many points are in each voxel, whatever the number of points per scan.
TEST(LocalMapper, UsesLargerVoxelsInRoomsForFewerPoints) {
  const auto scale = [](int points) {
    Insertions room(3.0, points);
    return room.state().map.fine().resolution() / room.voxel_size();
  };
  EXPECT_NEAR(scale(45000), 0.5 * std::sqrt(2.0), 1e-6);
  EXPECT_EQ(scale(4000), 1.0);
}

// Until scans fill small voxels there are large ones; then the map is built anew from these scans.
TEST(LocalMapper, RefinesAMapInARoomOnceItIsFilled) {
  Insertions room(3.0, 20000);
  const auto scale = [&] { return room.state().map.fine().resolution() / room.voxel_size(); };
  const auto insert_scan = [&](int i) { return room.insert_at(2.1 * (i % 2)); };
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(insert_scan(i));
  EXPECT_EQ(scale(), 1.0);
  EXPECT_TRUE(insert_scan(9));
  EXPECT_EQ(scale(), 0.5);
  const std::size_t voxels = room.state().map.fine().size();
  EXPECT_GT(voxels, 100U);
  for (int i = 10; i < 50; ++i) EXPECT_TRUE(insert_scan(i));
  EXPECT_EQ(scale(), 0.5);
  EXPECT_LT(room.state().map.fine().size(), voxels + voxels / 10) << "all were in it before";
}

TEST(LocalMapper, TakesScansOfFewPointsAsThoseOfAStreet) {
  EXPECT_TRUE(Insertions(3.0, 4000).mapper().is_indoors());
  EXPECT_FALSE(Insertions(3.0, 1000).mapper().is_indoors());
}

/// What a sensor a metre above the floor sees in a round room of this radius (m) with this number
/// of rings, from -15 to 15 degrees.
Scan scan_of_room(double radius, int rings) {
  Scan scan;
  for (int i = 0; i < 900; ++i) {
    const double azimuth = 2.0 * M_PI * i / 900.0;
    for (int ring = 0; ring < rings; ++ring) {
      const double slope = std::tan((30.0 * ring / (rings - 1.0) - 15.0) * M_PI / 180.0);
      const double distance = slope < 0.0 ? std::min(radius, -1.0 / slope) : radius;
      scan.cloud.points.push_back({static_cast<float>(distance * std::cos(azimuth)),
                                   static_cast<float>(distance * std::sin(azimuth)),
                                   static_cast<float>(distance * slope), 0.0F});
    }
  }
  return scan;
}

/// Points between the rings of a map's first scan.
SampledPoints first_points_between_rings(const Scan& scan) {
  FrontEndConfig config;
  SweepSampler sweep(config);
  LocalMapper mapper(config);
  sweep.set_viewpoint_at_origin();
  mapper.set_viewpoint_at_origin();
  TrackerState state(config);
  StepTimer timer;
  sweep.sample(scan, 0);
  start_motion(Pose{}, 0.0, state);
  mapper.start_map(scan, Pose{}, sweep, state.map);
  mapper.insert(scan, sweep, state, timer);
  return mapper.first_points_between_rings(scan, sweep);
}

TEST(LocalMapper, GivesPointsOfTheFloorBetweenTheRingsOfARoom) {
  const SampledPoints points = first_points_between_rings(scan_of_room(9.0, 16));
  EXPECT_GT(points.size(), 300U);
  for (const float z : points.z) EXPECT_NEAR(z, -1.0, 1e-3);
}

TEST(LocalMapper, GivesNoPointsBetweenRingsThatCannotBeDistinguished) {
  EXPECT_EQ(first_points_between_rings(scan_of_room(9.0, 500)).size(), 0U);
}

TEST(LocalMapper, GivesAllPointsBetweenTheRingsOutdoors) {
  const SampledPoints points = first_points_between_rings(scan_of_room(20.0, 16));
  EXPECT_GT(std::count_if(points.z.begin(), points.z.end(), [](float z) { return z > 0.0F; }), 100);
}

TEST(TrackerState, StartsAtThePoseOfTheStamp) {
  const FrontEndConfig config;
  TrackerState state(config);
  start_motion(ahead(7.0), 0.0, state);
  SweepSampler sweep(config);
  sweep.sample(scan_of_walls(20.0), 0);
  TrackedScan result;
  set_motion_at_stamp(state, sweep, result);
  EXPECT_EQ(result.T_odom_base.translation, ahead(7.0).translation);
  EXPECT_FALSE(result.motion_known);
  EXPECT_LT(result.covariance(0, 0), 1e-6) << "the first pose is known by definition";
}

TEST(Coasting, SlowsDownUntilTheMapIsGivenUp) {
  TrackerState state{FrontEndConfig{}};
  state.filter.restart(moving(0.0, 10.0), 0.01 * Matrix12d::Identity());
  state.motion_known = true;
  coast(0.5, state);
  EXPECT_NEAR(state.filter.state().twist[0], 10.0 * std::exp(-0.5), 1e-9);
  EXPECT_EQ(state.covariance, state.filter.covariance());
  EXPECT_TRUE(keeps_map(state, 0.9));
  coast(0.5, state);
  EXPECT_FALSE(keeps_map(state, 0.9));
}

TEST(Coasting, GivesUpAMapOfOneScanAtOnce) {
  TrackerState state{FrontEndConfig{}};
  coast(0.1, state);
  EXPECT_FALSE(keeps_map(state, 10.0));
}

double information_ahead(const MotionPrior& prior) {
  MotionFilter filter(10.0, 5.0);
  filter.restart(moving(0.0, 10.0), 0.04 * Matrix12d::Identity());
  return measured_speed_information(MotionPredictor().predict(filter, prior, 0.1, 0.1),
                                    {Eigen::Vector3d::UnitX()});
}

TEST(MotionPredictor, ReportsTheUncertaintyOfTheSpeedByOtherSensors) {
  MotionPrior measured;
  measured.linear_velocity = Eigen::Vector3d(10.0, 0.0, 0.0);
  EXPECT_NEAR(information_ahead({}), 0.0, 1e-6);
  EXPECT_GT(information_ahead(measured), 1.0);
}

TEST(MotionPredictor, PredictsWithLargeAndUsualAccelerations) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(ahead(1.0), 0.1, 0.1);
  const PredictedMotion predicted = MotionPredictor().predict(filter, {}, 0.1, 0.1);
  EXPECT_GT(predicted.high_noise_filter.covariance()(0, 0), predicted.filter.covariance()(0, 0));
  EXPECT_EQ(predicted.beliefs.nominal.state.T_map_sensor.translation,
            predicted.filter.state().T_map_sensor.translation);
  EXPECT_DOUBLE_EQ(filter.covariance()(0, 0), 1e-8) << "the filter itself is not predicted";
}

/// A good match at this position (m), from a prior that allows any motion.
StepMatch good_match_at(double x) {
  StepMatch match;
  match.found.match.state = moving(x, 10.0);
  match.found.match.converged = true;
  match.found.match.overlap = 0.9;
  match.found.match.quality = 0.8;
  match.found.match.pose_hessian = 1e6 * Matrix6d::Identity();
  match.found.match.points_information = match.found.match.information =
      1e6 * Matrix12d::Identity();
  match.prior = {match.found.match.state, Matrix12d::Identity()};
  return match;
}

FrontEndStatus status_of_a_match_at(double x, bool motion_known) {
  const FrontEndConfig config;
  TrackerState state(config);
  start_motion(Pose{}, 0.0, state);
  state.motion_known = motion_known;
  SweepSampler sweep(config);
  sweep.sample(scan_of_walls(20.0), 0);
  FrontEndStatus status;
  StepJudge(50.0).judge(good_match_at(x), state, sweep, 0.1, status);
  return status;
}

TEST(StepJudge, LosesAMotionThatNoVehicleCanMake) {
  EXPECT_NE(status_of_a_match_at(1.0, true).state, TrackingState::kLost);
  EXPECT_EQ(status_of_a_match_at(100.0, true).state, TrackingState::kLost);
  EXPECT_NE(status_of_a_match_at(100.0, false).state, TrackingState::kLost)
      << "before the second match the motion is not known";
}

// The clock is set by decades while the vehicle stands: the noise of its twist is no motion of
// thousands of kilometres.
TEST(StepJudge, ExpectsNoMotionOverAGap) {
  constexpr double kGap = 1e9;
  TrackerState state{FrontEndConfig{}};
  start_motion(Pose{}, 0.0, state);
  state.motion_known = true;
  StepMatch match = good_match_at(0.0);
  MotionState& matched = match.found.match.state;
  matched.twist << 0.01, 0.0, 0.0, 0.0, 0.0, 0.001;
  state.filter.correct(matched, 1e-6 * Matrix12d::Identity());
  state.filter.predict(kGap);
  Scan scan = scan_of_walls(20.0);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    scan.cloud.times.push_back(0.1F * static_cast<float>(i) / 4000.0F);
  SweepSampler sweep{FrontEndConfig{}};
  sweep.sample(scan, 0);
  FrontEndStatus status;
  StepJudge judge(50.0);
  judge.advance(kGap);
  judge.judge(match, state, sweep, kGap, status);
  EXPECT_LT(status.evidence.motion_change, 0.06);
  EXPECT_LT(status.evidence.motion_change_angle, 0.006);
  EXPECT_LT(status.evidence.sweep_gap, 0.11);
  EXPECT_GT(status.evidence.turn, 0.0);
  EXPECT_LT(status.evidence.turn, 0.006);
}

TEST(StepJudge, DescribesTheMatch) {
  const FrontEndStatus status = status_of_a_match_at(1.0, true);
  EXPECT_TRUE(status.converged);
  EXPECT_EQ(status.overlap, 0.9);
  EXPECT_GT(status.evidence.points, 50.0);
  EXPECT_GT(status.evidence.sigma, 0.0);
  EXPECT_GT(status.probability, 0.0);
  EXPECT_TRUE(status.degenerate_directions.empty());
}

}  // namespace
}  // namespace lidar_mapping::front_end
