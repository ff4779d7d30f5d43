// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "near.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::near;
using loop_closing::test::Box;

/// Poses along a line, two metres apart.
std::vector<Pose> line(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return along({from, to}, 2.0);
}

/// The number of results until the place was found; none if it never was.
std::optional<std::size_t> found_after(const std::vector<LocalizationResult>& results) {
  const auto found =
      std::find_if(results.begin(), results.end(),
                   [](const LocalizationResult& result) { return has_pose(result.state); });
  if (found == results.end()) return std::nullopt;
  return static_cast<std::size_t>(found - results.begin());
}

/// All poses are right to `tolerance_m`.
void expect_right(const std::vector<LocalizationResult>& results, const std::vector<Pose>& truth,
                  double tolerance_m = 0.15) {
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!has_pose(results[i].state)) continue;
    EXPECT_TRUE(near(results[i].T_map_base, truth[i], tolerance_m, 0.01))
        << "scan " << i << ": " << results[i].reason;
  }
}

/// Drives along a path, on which the place has to be found and all poses have to be right.
std::vector<LocalizationResult> expect_found(Vehicle& vehicle, const std::vector<Pose>& path) {
  std::vector<LocalizationResult> results = vehicle.drive(path);
  EXPECT_TRUE(found_after(results).has_value()) << results.back().reason;
  expect_right(results, path);
  return results;
}

std::size_t count(const std::vector<LocalizationResult>& results, LocalizationState state) {
  return static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(),
                    [&](const LocalizationResult& result) { return result.state == state; }));
}

TEST(Localizer, FindsItsPlaceWhileDrivingWithoutAnInitialPose) {
  Vehicle vehicle(town(), town_map());
  const auto path = line({-50.0, -1.0}, {0.0, -1.0});
  const auto results = vehicle.drive(path);
  const auto found = found_after(results);
  ASSERT_TRUE(found.has_value()) << results.back().reason;
  EXPECT_LT(*found, 20U);
  EXPECT_GT(*found, 0U);  // one scan alone is never enough
  EXPECT_EQ(count(results, LocalizationState::kFollowing), path.size() - *found);
  expect_right(results, path);
  EXPECT_GT(results.back().probability, 0.99);
}

TEST(Localizer, GivesTheMatchedPointsWhileThereIsAPose) {
  Vehicle vehicle(town(), town_map());
  Localizer& localizer = vehicle.localizer();
  EXPECT_TRUE(localizer.matched_points().empty());
  for (const Pose& pose : line({-50.0, -1.0}, {0.0, -1.0})) {
    const LocalizationResult result = vehicle.go_to(pose);
    EXPECT_EQ(localizer.matched_points().empty(), !has_pose(result.state)) << result.reason;
  }
  EXPECT_GT(localizer.matched_points().size(), 150U);
  localizer.restart();
  EXPECT_TRUE(localizer.matched_points().empty());
}

TEST(Localizer, FindsItselfInTheOppositeDirectionOnTheOtherLane) {
  Vehicle vehicle(town(), town_map());
  expect_found(vehicle, line({20.0, 2.0}, {-40.0, 2.0}));
}

// Of a wall its scans see what is too high for the LiDAR that made the map.
TEST(Localizer, FindsItsPlaceInTheMapOfALidarThatLooksDownwards) {
  const ToyWorld seen = seen_downwards(town());
  ToyMap map(seen, along({{-90.0, 0.0}, {48.0, 0.0}}));
  Vehicle vehicle(town(), map.index());
  expect_found(vehicle, line({-50.0, -1.0}, {0.0, -1.0}));
}

TEST(Localizer, FindsItselfAtRestInAnyHeading) {
  for (const double heading : {0.7, 2.4, -1.1}) {
    Vehicle vehicle(town(), town_map());
    SCOPED_TRACE(heading);
    expect_found(vehicle, std::vector<Pose>(20, planar(-30.0, 1.0, heading)));
  }
}

TEST(Localizer, FindsNothingInAnotherTown) {
  const ToyWorld elsewhere = make_town(150.0, kStreets, 77);
  Vehicle vehicle(elsewhere, town_map());
  const auto results = vehicle.drive(line({-60.0, 0.0}, {-10.0, 0.0}));
  EXPECT_FALSE(found_after(results).has_value());
  EXPECT_EQ(results.back().state, LocalizationState::kSearching);
}

TEST(Localizer, ClaimsACovarianceThatItsErrorsHave) {
  Vehicle vehicle(town(), town_map());
  const auto path = line({-60.0, 0.5}, {20.0, 0.5});
  const auto results = vehicle.drive(path);
  double sum = 0.0;
  std::size_t followed = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (results[i].state != LocalizationState::kFollowing) continue;
    EXPECT_TRUE(is_valid_covariance(results[i].covariance));
    // The map itself is no better than this, however many points agree.
    EXPECT_GE(results[i].covariance.diagonal().head<3>().minCoeff(), 0.002 * 0.002);
    EXPECT_GE(results[i].covariance.diagonal().tail<3>().minCoeff(), 1e-4 * 1e-4);
    const Vector6d error = difference(results[i].T_map_base, path[i]);
    sum += error.dot(results[i].covariance.ldlt().solve(error)) / 6.0;
    ++followed;
  }
  ASSERT_GT(followed, 20U);
  EXPECT_LT(sum / static_cast<double>(followed), 2.0);
}

Box moved_east(const Box& box) {
  const Eigen::Vector3d east(400.0, 0.0, 0.0);
  return {box.low + east, box.high + east};
}

/// Houses of the town with x < 150, and the same once more 400 m east; far up the street along y
/// the two differ.
ToyWorld twin_world() {
  ToyWorld world;
  const ToyWorld first = make_town(120.0, kStreets, 5);
  const ToyWorld other = make_town(120.0, kStreets, 6);
  for (const Box& box : first.boxes) {
    world.boxes.push_back(box);
    if (box.low.y() <= 30.0) world.boxes.push_back(moved_east(box));
  }
  for (const Box& box : other.boxes) {
    if (box.low.y() > 30.0) world.boxes.push_back(moved_east(box));
  }
  return world;
}

class Twins : public testing::Test {
 protected:
  static const ToyWorld& world() {
    static const ToyWorld made = twin_world();
    return made;
  }
  static MapIndex& map() {
    static ToyMap made(world(), both_streets());
    return made.index();
  }
  /// Up the first of the two streets.
  static std::vector<Pose> way() { return line({0.0, -95.0}, {0.0, 95.0}); }
  /// The first scan that sees a house which the other street does not have.
  static constexpr std::size_t kDiffersFrom = (95 + 30 - 60) / 2;

 private:
  static std::vector<Pose> both_streets() {
    std::vector<Pose> poses = along({{0.0, -100.0}, {0.0, 100.0}});
    for (const Pose& pose : along({{400.0, -100.0}, {400.0, 100.0}})) poses.push_back(pose);
    return poses;
  }
};

TEST_F(Twins, StayUndecidedUntilThePathDistinguishesThem) {
  Vehicle vehicle(world(), map());
  const auto path = way();
  const auto results = vehicle.drive(path);
  EXPECT_EQ(results[kDiffersFrom].hypotheses, 2U) << results[kDiffersFrom].reason;
  EXPECT_NE(results[kDiffersFrom].reason.find("2 places look alike"), std::string::npos);
  EXPECT_LT(results[kDiffersFrom].probability, 0.6);
  const auto found = found_after(results);
  ASSERT_TRUE(found.has_value()) << results.back().reason;
  EXPECT_GT(*found, kDiffersFrom);
  expect_right(results, path);
}

TEST_F(Twins, AreDistinguishedByAnInitialPose) {
  for (const double east : {0.0, 400.0}) {
    Vehicle vehicle(world(), map());
    vehicle.localizer().set_initial_pose(planar(east + 2.0, -93.0, 1.5));
    expect_found(vehicle, line({east, -95.0}, {east, -50.0}));
  }
}

// rviz gives the height 0, wherever the ground is.
TEST_F(Twins, AreDistinguishedByAnInitialPoseOfAnotherHeight) {
  Vehicle vehicle(world(), map());
  Pose claimed = planar(402.0, -93.0, 1.5);
  claimed.translation.z() = 30.0;
  vehicle.localizer().set_initial_pose(claimed);
  expect_found(vehicle, line({400.0, -95.0}, {400.0, -50.0}));
}

/// A town, and the same once more 400 m east.
ToyWorld same_town_twice() {
  ToyWorld world = make_town(120.0, kStreets, 5);
  const std::vector<Box> first = world.boxes;
  for (const Box& box : first) world.boxes.push_back(moved_east(box));
  return world;
}

TEST(Localizer, IsNotWhereTheMapEnded) {
  const ToyWorld world = same_town_twice();
  std::vector<Pose> mapped = along({{0.0, -100.0}, {0.0, 100.0}});
  for (const Pose& pose : along({{400.0, -100.0}, {400.0, -50.0}})) mapped.push_back(pose);
  ToyMap map(world, mapped);
  Vehicle vehicle(world, map.index());
  const auto path = line({0.0, -95.0}, {0.0, 95.0});
  const auto results = vehicle.drive(path);
  EXPECT_EQ(results[15].hypotheses, 2U) << results[15].reason;
  const auto found = found_after(results);
  ASSERT_TRUE(found.has_value()) << results.back().reason;
  EXPECT_GT(path[*found].translation.y(), -50.0);
  expect_right(results, path);
}

TEST(Localizer, IsNotMisledByAWrongInitialPose) {
  Vehicle vehicle(town(), town_map());
  vehicle.localizer().set_initial_pose(planar(48.0, 60.0, 1.57));
  expect_found(vehicle, line({-50.0, -1.0}, {0.0, -1.0}));
}

TEST(Localizer, CrossesByOdometryWhatTheMapDoesNotContain) {
  Vehicle vehicle(town(), town_map());
  auto path = line({-40.0, 0.0}, {0.0, 0.0});
  for (const Pose& pose : line({0.0, 0.0}, {0.0, -130.0})) path.push_back(pose);
  for (const Pose& pose : line({0.0, -130.0}, {0.0, 0.0})) path.push_back(pose);
  for (const Pose& pose : line({0.0, 0.0}, {30.0, 0.0})) path.push_back(pose);
  const auto results = vehicle.drive(path);
  EXPECT_GT(count(results, LocalizationState::kBesideMap), 20U);
  EXPECT_EQ(count(results, LocalizationState::kLost), 0U);
  EXPECT_EQ(results.back().state, LocalizationState::kFollowing) << results.back().reason;
  expect_right(results, path, 0.5);
}

TEST(Localizer, NoticesThatItWasKidnappedAndFindsItselfAgain) {
  Vehicle vehicle(town(), town_map());
  ASSERT_TRUE(has_pose(vehicle.drive(line({-80.0, 0.0}, {-40.0, 0.0})).back().state));
  const auto path = line({48.0, 20.0}, {48.0, 80.0});
  const auto results = vehicle.drive(path, planar(1.0, 0.0, 0.0));
  EXPECT_NE(results.front().state, LocalizationState::kFollowing) << results.front().reason;
  EXPECT_GT(count(results, LocalizationState::kLost), 0U);
  ASSERT_EQ(results.back().state, LocalizationState::kFollowing) << results.back().reason;
  EXPECT_TRUE(near(results.back().T_map_base, path.back(), 0.15, 0.01));
}

/// No scan is followed at a wrong pose.
void expect_never_wrong_in_silence(const std::vector<LocalizationResult>& results,
                                   const std::vector<Pose>& truth) {
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].state != LocalizationState::kFollowing) continue;
    EXPECT_TRUE(near(results[i].T_map_base, truth[i], 0.3, 0.02))
        << "scan " << i << ": " << results[i].reason;
  }
}

/// At 8 m/s.
std::vector<Pose> at_speed(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return along({from, to}, 0.8);
}

TEST(Localizer, IsNeverWrongInSilenceWhenItIsCarriedAlongItsStreet) {
  for (const double metres : {12.0, 33.0, 60.0}) {
    Vehicle vehicle(town(), town_map());
    const auto before = at_speed({-85.0, 0.0}, {-60.0, 0.0});
    ASSERT_TRUE(has_pose(vehicle.drive(before).back().state));
    const auto path = at_speed({-60.0 + metres, 0.0}, {-15.0 + metres, 0.0});
    const auto results = vehicle.drive(path, planar(0.8, 0.0, 0.0));
    EXPECT_NE(results.front().state, LocalizationState::kFollowing) << metres;
    expect_never_wrong_in_silence(results, path);
    EXPECT_EQ(results.back().state, LocalizationState::kFollowing)
        << metres << ": " << results.back().reason;
  }
}

TEST(Localizer, FindsItselfAgainAfterABlackOut) {
  Vehicle vehicle(town(), town_map());
  ASSERT_TRUE(has_pose(vehicle.drive(at_speed({-85.0, 0.0}, {-60.0, 0.0})).back().state));
  vehicle.interrupt();  // five seconds without a scan
  const auto path = at_speed({-20.0, 0.0}, {20.0, 0.0});
  const auto results = vehicle.drive(path);
  EXPECT_EQ(results.front().state, LocalizationState::kLost);
  expect_never_wrong_in_silence(results, path);
  EXPECT_EQ(results.back().state, LocalizationState::kFollowing) << results.back().reason;
}

// Odometry believes that it stands still.
TEST(Localizer, ClaimsNothingThroughACoveredSensor) {
  Vehicle vehicle(town(), town_map());
  ASSERT_TRUE(has_pose(vehicle.drive(at_speed({-85.0, 0.0}, {-60.0, 0.0})).back().state));
  vehicle.see_only(40);
  std::vector<Pose> path = at_speed({-60.0, 0.0}, {-20.0, 0.0});
  std::vector<LocalizationResult> results;
  for (const Pose& pose : path) results.push_back(vehicle.go_to(pose, Pose::Identity()));
  EXPECT_EQ(count(results, LocalizationState::kFollowing), 0U);
  vehicle.see_only(1'000'000);
  for (const Pose& pose : at_speed({-20.0, 0.0}, {20.0, 0.0})) {
    path.push_back(pose);
    results.push_back(vehicle.go_to(pose));
  }
  expect_never_wrong_in_silence(results, path);
  EXPECT_EQ(results.back().state, LocalizationState::kFollowing) << results.back().reason;
}

TEST(Localizer, GivesUpAPlaceThatOdometryHasLeftUnknown) {
  Vehicle vehicle(town(), town_map());
  ASSERT_TRUE(has_pose(vehicle.drive(at_speed({-85.0, 0.0}, {-60.0, 0.0})).back().state));
  vehicle.see_only(40);
  vehicle.distrust_odometry(0.5);
  const auto results = vehicle.drive(at_speed({-60.0, 0.0}, {60.0, 0.0}));
  EXPECT_EQ(results.front().state, LocalizationState::kBesideMap);
  EXPECT_EQ(results.back().state, LocalizationState::kLost);
  EXPECT_NE(results.back().reason.find("is above 5 m"), std::string::npos);
}

TEST(Localizer, SearchesAgainAfterAnInterruptionOfOdometry) {
  Vehicle vehicle(town(), town_map());
  ASSERT_TRUE(has_pose(vehicle.drive(line({-80.0, 0.0}, {-40.0, 0.0})).back().state));
  vehicle.interrupt();
  const auto results = expect_found(vehicle, line({48.0, 20.0}, {48.0, 60.0}));
  EXPECT_EQ(results.front().state, LocalizationState::kLost);
  EXPECT_NE(results.front().reason.find("odometry was interrupted"), std::string::npos);
}

TEST(Localizer, SearchesAgainWhenAPersonWantsIt) {
  Vehicle vehicle(town(), town_map());
  ASSERT_TRUE(has_pose(vehicle.drive(line({-80.0, 0.0}, {-40.0, 0.0})).back().state));
  vehicle.localizer().restart();
  const auto results = expect_found(vehicle, line({-38.0, 0.0}, {0.0, 0.0}));
  EXPECT_EQ(results.front().state, LocalizationState::kSearching);
  EXPECT_FALSE(has_pose(results.front().state));
}

TEST(Localizer, HasTheSameResultsEveryTime) {
  const auto path = line({-50.0, 1.0}, {-20.0, 1.0});
  Vehicle first(town(), town_map()), second(town(), town_map());
  const auto a = first.drive(path), b = second.drive(path);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(a[i].state, b[i].state);
    EXPECT_EQ(a[i].T_map_base.translation, b[i].T_map_base.translation);
    EXPECT_EQ(a[i].covariance, b[i].covariance);
    EXPECT_EQ(a[i].probability, b[i].probability);
  }
}

TEST(Localizer, RefusesStampsThatDoNotIncrease) {
  Localizer localizer(town_map());
  LocalizerInput input;
  input.scan.stamp = 5;
  localizer.process(input);
  EXPECT_THROW(localizer.process(input), InputError);
}

TEST(Localizer, LivesWithScansWithoutPoints) {
  Localizer localizer(town_map());
  LocalizerInput empty;
  empty.scan.stamp = 1;
  const LocalizationResult result = localizer.process(empty);
  EXPECT_EQ(result.state, LocalizationState::kSearching);
  EXPECT_EQ(result.hypotheses, 0U);
}

TEST(MapIndex, RefusesAMapWithoutPlacesOrClouds) {
  DriveClouds none(town(), {});
  EXPECT_THROW(MapIndex({}, none, {}), InputError);
  EXPECT_THROW(MapIndex(source_of({Pose::Identity()}), none, {}), InputError);
}

TEST(MapIndex, KnowsItsPlacesAndItsSize) {
  EXPECT_EQ(town_map().places().size(), 114U);
  EXPECT_GT(town_map().gaussians(), 3000U);
  EXPECT_GE(town_map().bytes(), 64 * town_map().gaussians());
}

}  // namespace
}  // namespace lidar_mapping::localization::test
