// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include "drive.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

// A square that ends at its start closes on the first key frames, without GNSS, although odometry
// ends 20 m away from the start.
TEST(LoopCloser, ClosesASquareOnItsFirstKeyFrames) {
  const ToyWorld world = make_town(120.0, 60.0, 1);
  const auto truth = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {16, 0}});
  auto odometry = drifting(truth, 1.0, 0.0);
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    odometry[i].translation.x() += 20.0 * static_cast<double>(i) / 120.0;
  }
  LoopClosingConfig config;
  config.horizontal_drift = 0.04;
  const DriveOutcome outcome = drive(world, truth, odometry, config);
  EXPECT_EQ(outcome.false_loops, 0);
  ASSERT_FALSE(outcome.loops.empty());
  const auto is_older = [](const Loop& a, const Loop& b) { return a.from < b.from; };
  EXPECT_LE(std::min_element(outcome.loops.begin(), outcome.loops.end(), is_older)->from, 5U);
}

/// A square whose odometry slips on the far side and ends `metres` beside the start.
DriveOutcome square_with_end_error(double metres, bool appearance) {
  const ToyWorld world = make_town(120.0, 60.0, 1);
  const auto truth = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {16, 0}});
  auto odometry = truth;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    odometry[i].translation.x() +=
        metres * std::clamp(static_cast<double>(i) / 40.0 - 1.0, 0.0, 1.0);
  }
  LoopClosingConfig config;
  config.horizontal_drift = 0.002 * metres;
  config.appearance_candidates = appearance;
  return drive(world, truth, odometry, config);
}

// With this odometry, the nearest key frames in the estimate are at another location.
TEST(LoopCloser, AppearanceFindsLoopsThatPositionMisses) {
  const DriveOutcome by_position = square_with_end_error(90.0, false);
  EXPECT_TRUE(by_position.loops.empty());
  const DriveOutcome by_appearance = square_with_end_error(90.0, true);
  EXPECT_EQ(by_appearance.false_loops, 0);
  ASSERT_FALSE(by_appearance.loops.empty());
  for (const Loop& loop : by_appearance.loops) EXPECT_EQ(loop.source, LoopSource::kAppearance);
}

/// Forward and back along x; the scale error of odometry is -5 %.
DriveOutcome forward_and_back(const ToyWorld& world) {
  const auto truth = along({{-60, 0}, {60, 0}, {60, 2}, {-60, 2}});
  return drive(world, truth, drifting(truth, 0.95, 0.0));
}

// In a smooth tunnel a scan fits everywhere along the axis.
TEST(LoopCloser, AcceptsNothingInATunnel) {
  ToyWorld tunnel;
  tunnel.boxes = {{{-300, -6, 0}, {300, -5, 7}}, {{-300, 5, 0}, {300, 6, 7}}};
  const DriveOutcome outcome = forward_and_back(tunnel);
  EXPECT_TRUE(outcome.loops.empty());
  EXPECT_FALSE(outcome.verdicts.empty());
}

// Without points above the ground there is no decision.
TEST(LoopCloser, LeavesAnOpenFieldUndecided) {
  const DriveOutcome outcome = forward_and_back(ToyWorld());
  EXPECT_TRUE(outcome.loops.empty());
  ASSERT_FALSE(outcome.verdicts.empty());
  for (const LoopVerdict& verdict : outcome.verdicts) {
    EXPECT_NE(verdict.verdict, Verdict::kAccepted) << verdict.reason;
  }
}

// Driving back through the same street without an absolute heading: at least one loop every ten
// metres.
TEST(LoopCloser, ClosesAStreetDrivenInTheOppositeDirection) {
  const ToyWorld world = make_town(150.0, 100.0, 2);
  const auto truth = along({{0, 0}, {100, 0}, {100, 3.5}, {0, 3.5}});
  const DriveOutcome outcome = drive(world, truth, drifting(truth, 1.01, 2e-4));
  EXPECT_EQ(outcome.false_loops, 0);
  ASSERT_FALSE(outcome.loops.empty());
  for (std::size_t i = 1; i < outcome.loops.size(); ++i) {
    EXPECT_LE(outcome.loops[i].to - outcome.loops[i - 1].to, 5U);
  }
  EXPECT_GE(outcome.loops.back().to, truth.size() - 6);
  for (const LoopVerdict& verdict : outcome.verdicts) {
    EXPECT_FALSE(verdict.reason.empty());
    EXPECT_LT(verdict.from, verdict.to);
  }
}

/// The largest number of candidates that one search matched in a third pass through a street. Both
/// older passes can be found. Odometry turns by `turning` (rad/m) too much.
std::size_t max_matched(double horizontal_drift, double turning, int max_registrations = 50) {
  const ToyWorld world = make_town(150.0, 100.0, 2);
  const auto truth = along({{0, 0}, {60, 0}, {60, 3.5}, {0, 3.5}, {0, 0}, {60, 0}});
  LoopClosingConfig config;
  config.horizontal_drift = horizontal_drift;
  config.max_registrations = max_registrations;
  const DriveOutcome outcome = drive(world, truth, drifting(truth, 1.0, turning), config);
  EXPECT_EQ(outcome.false_loops, 0);
  std::map<KeyFrameIndex, std::size_t> matched;
  for (const LoopVerdict& verdict : outcome.verdicts) {
    if (verdict.to > 70) ++matched[verdict.to];
  }
  EXPECT_FALSE(matched.empty());
  std::size_t most = 0;
  for (const auto& [to, count] : matched) most = std::max(most, count);
  return most;
}

TEST(LoopCloser, MatchesOneCandidateIfTheEstimateIsCertain) {
  EXPECT_EQ(max_matched(0.003, 0.0), 1U);
}

TEST(LoopCloser, MatchesNoOtherPassOfAStreetWhereTheFirstOneAgreesWithAnUncertainEstimate) {
  EXPECT_EQ(max_matched(0.02, 0.0), 1U);
}

TEST(LoopCloser, MatchesAllCandidatesIfTheEstimateIsUncertainAndOff) {
  EXPECT_EQ(max_matched(0.02, 5e-4), 2U);
}

TEST(LoopCloser, MatchesNoMoreCandidatesThanConfigured) {
  EXPECT_EQ(max_matched(0.02, 5e-4, 1), 1U);
  EXPECT_EQ(max_matched(0.02, 5e-4, 3), 2U) << "there are no more";
}

// A crossing where the headings differ by 90 degrees.
TEST(LoopCloser, ClosesACrossing) {
  const ToyWorld world = make_town(150.0, 100.0, 8);
  const auto truth = along({{-40, 0}, {40, 0}, {40, 40}, {0, 40}, {0, -20}});
  const DriveOutcome outcome = drive(world, truth, drifting(truth, 1.01, 2e-4));
  EXPECT_EQ(outcome.false_loops, 0);
  EXPECT_GE(outcome.loops.size(), 1U);
}

TEST(LoopCloser, FindsNothingWithoutRevisits) {
  const ToyWorld world = make_town(200.0, 100.0, 3);
  const auto truth = along({{-100, 0}, {100, 0}});
  EXPECT_TRUE(drive(world, truth, truth).loops.empty());
}

/// Round a block, its first side again, and on, with an estimate that excludes no place.
DriveOutcome drive_without_estimate() {
  const ToyWorld world = make_town(150.0, 60.0, 1);
  const auto truth =
      along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {60, 0}, {120, 0}, {120, 60}});
  LoopClosingConfig config;
  config.horizontal_drift = 0.2;
  config.rotation_drift = 20.0 * kRadPerDeg / 100.0;
  return drive(world, truth, drifting(truth, 1.01, 1e-4), config);
}

// Most candidates are other places then. A registration of each would cost more than all the rest.
TEST(LoopCloser, RefusesOtherPlacesBeforeTheyAreMatched) {
  const DriveOutcome outcome = drive_without_estimate();
  EXPECT_EQ(outcome.false_loops, 0);
  EXPECT_GE(outcome.loops.size(), 5U);
  int refused = 0;
  int before_a_match = 0;
  for (const LoopVerdict& verdict : outcome.verdicts) {
    if (verdict.verdict != Verdict::kRefused) continue;
    ++refused;
    if (verdict.reason.find("starting pose") != std::string::npos) ++before_a_match;
  }
  EXPECT_GE(refused, 20);
  EXPECT_GE(3 * before_a_match, refused);
}

/// A street along x, and the same street again 140 m to the left.
ToyWorld make_twin_streets(double extent) {
  ToyWorld world = make_town(extent, 100.0, 9);
  const std::size_t count = world.boxes.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Box& box = world.boxes[i];
    const Eigen::Vector3d shift(0.0, 140.0, 0.0);
    world.boxes.push_back({box.low + shift, box.high + shift});
  }
  return world;
}

// The clouds of twin streets cannot be distinguished; the estimate distinguishes them.
TEST(LoopCloser, NeverClosesBetweenTwinStreets) {
  const ToyWorld world = make_twin_streets(60.0);
  const auto truth = along({{-50, 0}, {50, 0}, {100, 70}, {50, 140}, {-50, 140}});
  const DriveOutcome outcome = drive(world, truth, drifting(truth, 1.01, 1e-4));
  EXPECT_TRUE(outcome.loops.empty());
}

/// Storeys of a car park, 3 m high, with pillars and a few parked cars that differ.
ToyWorld make_car_park() {
  ToyWorld world;
  world.floors = {0.0, 3.0, 6.0, 9.0};
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  world.boxes = {{{-40, -25, 0}, {40, -24, 9}},
                 {{-40, 24, 0}, {40, 25, 9}},
                 {{-40, -25, 0}, {-39, 25, 9}},
                 {{39, -25, 0}, {40, 25, 9}}};
  for (double x = -32.0; x <= 32.0; x += 8.0) {
    for (const double y : {-16.0, -6.0, 6.0, 16.0}) {
      world.boxes.push_back({{x - 0.3, y - 0.3, 0}, {x + 0.3, y + 0.3, 9}});
      for (const double floor : {0.0, 3.0, 6.0}) {
        if (chance(generator) < 0.5) continue;
        world.boxes.push_back({{x + 1, y - 1, floor}, {x + 3, y + 3, floor + 1.5}});
      }
    }
  }
  return world;
}

/// Up the ramps, with two turns on each storey.
std::vector<Pose> car_park_drive() {
  const auto round = along({{-30, 0}, {30, 0}, {30, 11}, {-30, 11}, {-30, 0}, {0, 0}}, 4.0);
  std::vector<Pose> truth;
  for (const double height : {0.0, 3.0, 6.0}) {
    for (Pose pose : round) {
      pose.translation.z() = height;
      truth.push_back(pose);
    }
    for (const double fraction : {0.25, 0.5, 0.75}) {
      truth.push_back(planar(30.0 - 60.0 * fraction, -11.0, kPi, height + 3.0 * fraction));
    }
  }
  return truth;
}

// Storeys that look alike are different locations.
TEST(LoopCloser, DistinguishesTheStoreysOfACarPark) {
  const ToyWorld world = make_car_park();
  const auto truth = car_park_drive();
  const DriveOutcome outcome = drive(world, truth, drifting(truth, 1.005, 1e-4, 1e-3));
  EXPECT_EQ(outcome.false_loops, 0);
  EXPECT_GE(outcome.loops.size(), 6U);
}

// An odometry that loses the height of a storey at the end of each ramp.
TEST(LoopCloser, DistinguishesStoreysThatOdometryConfuses) {
  const ToyWorld world = make_car_park();
  const auto truth = car_park_drive();
  auto odometry = truth;
  for (Pose& pose : odometry) pose.translation.z() = std::fmod(pose.translation.z(), 3.0);
  const DriveOutcome outcome = drive(world, truth, odometry);
  EXPECT_EQ(outcome.false_loops, 0);
  EXPECT_GE(outcome.loops.size(), 3U) << "one on each storey";
  const auto is_undecided = [](const LoopVerdict& v) { return v.verdict == Verdict::kUndecided; };
  EXPECT_GT(std::count_if(outcome.verdicts.begin(), outcome.verdicts.end(), is_undecided), 0);
}

// A drift of the height by 15 m does not hide the loop.
TEST(LoopCloser, ClosesInSpiteOfADriftInHeight) {
  const ToyWorld world = make_town(120.0, 60.0, 1);
  const auto truth = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {16, 0}}, 3.0);
  auto odometry = truth;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    odometry[i].translation.z() = 15.0 * std::clamp(static_cast<double>(i) / 20.0 - 1.0, 0.0, 1.0);
  }
  LoopClosingConfig config;
  config.vertical_drift = 0.1;
  const DriveOutcome outcome = drive(world, truth, odometry, config);
  EXPECT_EQ(outcome.false_loops, 0);
  EXPECT_FALSE(outcome.loops.empty());
}

// All sizes of submap and gap are possible, and scan and submap never share a cloud.
TEST(LoopCloser, AcceptsAllSubmapSizes) {
  const ToyWorld world = make_town(60.0, 100.0, 4);
  const auto truth = along({{0, 0}, {30, 0}, {30, 3.5}, {0, 3.5}});
  for (const int extend : {0, 1, 20}) {
    for (const int gap : {0, 5}) {
      LoopClosingConfig config;
      config.extend_frame_num = extend;
      config.diff_num = gap;
      config.accum_distance_thresh = 0.0;
      const DriveOutcome outcome = drive(world, truth, truth, config);
      EXPECT_EQ(outcome.false_loops, 0) << extend << " " << gap;
      for (const Loop& loop : outcome.loops) {
        EXPECT_GE(loop.to - loop.from, static_cast<KeyFrameIndex>(extend + 3));
      }
    }
  }
}

TEST(LoopCloser, ClosesWithUnfilteredClouds) {
  const ToyWorld world = make_town(60.0, 100.0, 4);
  const auto truth = along({{0, 0}, {40, 0}, {40, 3.5}, {0, 3.5}});
  LoopClosingConfig config;
  config.map_filter = FilterMethod::kNone;
  config.extend_frame_num = 1;
  config.scan_leaf_size = 0.8;
  std::map<FilterMethod, double> fitness;  // of the first loop
  for (const FilterMethod scan_filter : {FilterMethod::kVoxel, FilterMethod::kNone}) {
    config.scan_filter = scan_filter;
    const DriveOutcome outcome = drive(world, truth, truth, config);
    EXPECT_EQ(outcome.false_loops, 0);
    ASSERT_FALSE(outcome.loops.empty());
    fitness[scan_filter] = outcome.loops.front().fitness;
  }
  EXPECT_NE(fitness[FilterMethod::kVoxel], fitness[FilterMethod::kNone])
      << "the scan is thinned or not";
}

// After a restart the search continues as before.
TEST(LoopCloser, ClosesSoonAfterARestart) {
  const ToyWorld world = make_town(80.0, 100.0, 2);
  const auto truth = along({{0, 0}, {60, 0}, {60, 3.5}, {0, 3.5}});
  DriveClouds clouds(world, truth);
  for (const bool has_loop : {false, true}) {
    LoopCloser closer({}, clouds);
    const std::size_t stop = 45;
    for (std::size_t i = 0; i < stop; ++i) closer.restore(key_frame(i, truth[i]));
    Loop known;
    known.from = 17;
    known.to = stop - 1;
    closer.restore(has_loop ? std::vector<Loop>{known} : std::vector<Loop>{}, {}, {});
    EXPECT_EQ(closer.process(key_frame(stop, truth[stop])).verdicts.empty(), has_loop);
    DriveOutcome outcome;
    for (std::size_t i = stop + 1; i < stop + 5; ++i) {
      append(outcome, closer.process(key_frame(i, truth[i])), truth);
    }
    EXPECT_FALSE(outcome.verdicts.empty());
  }
}

// Loops are restored before the key frames that are searched again (min_edge_interval).
TEST(LoopCloser, FindsNoSecondLoopOfAKeyFrameThatIsSearchedAgain) {
  const ToyWorld world = make_town(80.0, 100.0, 2);
  const auto truth = along({{0, 0}, {60, 0}, {60, 3.5}, {0, 3.5}});
  DriveClouds clouds(world, truth);
  LoopCloser closer({}, clouds);
  const std::size_t stop = 45;
  for (std::size_t i = 0; i < stop; ++i) closer.restore(key_frame(i, truth[i]));
  Loop known;
  known.from = 17;
  known.to = stop;
  closer.restore({known}, {}, {});
  for (const std::size_t i : {stop, stop + 1}) {
    EXPECT_TRUE(closer.process(key_frame(i, truth[i])).verdicts.empty()) << i;
  }
}

// A front end that restarts begins a segment that odometry does not connect to the one before.
TEST(LoopCloser, ConnectsASegmentToTheOneBefore) {
  const ToyWorld world = make_town(80.0, 100.0, 2);
  const auto truth = along({{-50, 0}, {50, 0}});
  DriveClouds clouds(world, truth);
  LoopCloser closer({}, clouds);
  DriveOutcome outcome;
  const std::size_t reset = 30;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    KeyFrame key = key_frame(i, i < reset ? truth[i] : truth[reset].inverse() * truth[i]);
    key.segment = i < reset ? 0 : 1;
    append(outcome, closer.process(key), truth);
  }
  EXPECT_EQ(outcome.false_loops, 0);
  ASSERT_FALSE(outcome.loops.empty());
  EXPECT_LT(outcome.loops.front().from, reset);
  EXPECT_GE(outcome.loops.front().to, reset);
}

// Of a drive that sees nothing but a street that is there twice nobody can say where it was.
TEST(LoopCloser, DoesNotConnectASegmentInATwinStreet) {
  const ToyWorld world = make_twin_streets(90.0);
  auto truth = along({{-80, 0}, {80, 0}, {130, 70}, {80, 140}, {-80, 140}});
  const std::size_t mapped = truth.size();
  for (const Pose& pose : along({{-70, 0}, {70, 0}})) truth.push_back(pose);
  DriveClouds clouds(world, truth);
  LoopCloser closer({}, clouds);
  closer.set_sensor_origin(ToyWorld::sensor());
  DriveOutcome outcome;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    KeyFrame key = key_frame(i, i < mapped ? truth[i] : truth[mapped].inverse() * truth[i]);
    if (i >= mapped) {
      key.segment = 1;
      key.stamp += from_seconds(86400.0);  // the vehicle may have gone anywhere
    }
    append(outcome, closer.process(key), truth);
  }
  EXPECT_TRUE(outcome.loops.empty());
  EXPECT_FALSE(outcome.verdicts.empty());
}

TEST(LoopCloser, MissingCloudsLeaveCandidatesUndecided) {
  const ToyWorld world = make_town(60.0, 100.0, 4);
  const auto truth = along({{0, 0}, {60, 0}, {60, 3.5}, {0, 3.5}});
  DriveClouds clouds(world, {});
  LoopCloser closer({}, clouds);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (const LoopVerdict& v : closer.process(key_frame(i, truth[i])).verdicts) {
      EXPECT_EQ(v.verdict, Verdict::kUndecided);
    }
  }
}

// Key frames can be prepared in advance in another thread.
TEST(LoopCloser, GivesTheSameBytesForKeyFramesPreparedInAdvance) {
  const ToyWorld world = make_town(60.0, 100.0, 4);
  const auto truth = along({{0, 0}, {40, 0}, {40, 3.5}, {0, 3.5}});
  const DriveOutcome expected = drive(world, truth, truth);
  DriveClouds clouds(world, truth);
  KeyFramePreparation preparation{LoopClosingConfig()};
  LoopCloser closer({}, clouds);
  closer.set_sensor_origin(ToyWorld::sensor());
  DriveOutcome outcome;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const PreparedKeyFrame prepared =
        preparation.prepare(*clouds.cloud(static_cast<KeyFrameIndex>(i)));
    append(outcome, closer.process(key_frame(i, truth[i]), prepared), truth);
  }
  ASSERT_FALSE(outcome.loops.empty());
  ASSERT_EQ(outcome.loops.size(), expected.loops.size());
  for (std::size_t i = 0; i < outcome.loops.size(); ++i) {
    EXPECT_EQ(outcome.loops[i].T_from_to.matrix(), expected.loops[i].T_from_to.matrix());
  }
}

TEST(LoopCloser, GivesTheSameBytesAgain) {
  const ToyWorld world = make_town(60.0, 100.0, 4);
  const auto truth = along({{0, 0}, {40, 0}, {40, 3.5}, {0, 3.5}});
  const DriveOutcome a = drive(world, truth, truth);
  const DriveOutcome b = drive(world, truth, truth);
  ASSERT_EQ(a.loops.size(), b.loops.size());
  for (std::size_t i = 0; i < a.loops.size(); ++i) {
    EXPECT_EQ(a.loops[i].T_from_to.matrix(), b.loops[i].T_from_to.matrix());
  }
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
