// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "visibility/observing_scan.hpp"

namespace lidar_mapping::moving_objects {
namespace {

/// A wall across the x axis of the map at x (m), as a sensor at `p_map_sensor` sees it.
ObservingScan scan_of_wall(double x, const Eigen::Vector3d& p_map_sensor = {0.0, 0.0, 0.0},
                           const Pose& T_moved_map = Pose()) {
  PointCloud cloud;
  // Dense enough to fill the pixels of 0.4 by 0.5 degrees.
  const double distance = x - p_map_sensor.x();
  for (double y = -6.0; y <= 6.0; y += 0.005 * distance) {
    for (double z = -2.0; z <= 2.0; z += 0.007 * distance) {
      const Eigen::Vector3f p = (Eigen::Vector3d(x, y, z) - p_map_sensor).cast<float>();
      cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
    }
  }
  Pose T_map_sensor;
  T_map_sensor.translation = p_map_sensor;
  return {(T_moved_map * T_map_sensor).inverse(), RangeImage(cloud, Eigen::Vector3f::Zero()), {}};
}

PointCloud cloud_at(const std::vector<Eigen::Vector3f>& positions) {
  PointCloud cloud;
  for (const Eigen::Vector3f& p : positions) cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
  return cloud;
}

std::vector<std::uint32_t> all_of(const PointCloud& cloud) {
  std::vector<std::uint32_t> indices(cloud.size());
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

std::vector<const ObservingScan*> pointers_to(const std::vector<ObservingScan>& scans) {
  std::vector<const ObservingScan*> pointers;
  for (const ObservingScan& scan : scans) pointers.push_back(&scan);
  return pointers;
}

std::vector<Vote> votes_on(const std::vector<Eigen::Vector3f>& positions,
                           const std::vector<ObservingScan>& scans,
                           const MovingObjectsConfig& config = {}) {
  const PointCloud cloud = cloud_at(positions);
  return collect_votes(cloud, Pose(), all_of(cloud), pointers_to(scans), config);
}

/// The vote of scans of which so many saw through 10 m ahead, and so many saw something there.
Vote vote_of(int through, int hits, const MovingObjectsConfig& config = {}) {
  static const ObservingScan farther = scan_of_wall(20.0), nearer = scan_of_wall(10.0);
  std::vector<ObservingScan> scans(static_cast<std::size_t>(through), farther);
  scans.resize(static_cast<std::size_t>(through + hits), nearer);
  return votes_on({{10.0F, 0.0F, 0.0F}}, scans, config).front();
}

TEST(CollectVotes, AreMovingWhereSeenThroughAndStaticWhereHit) {
  const std::vector<ObservingScan> scans(3, scan_of_wall(20.0));
  EXPECT_EQ(
      votes_on({{10.0F, 0.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {30.0F, 0.0F, 0.0F}, {-5.0F, 0.0F, 0.0F}},
               scans),
      (std::vector<Vote>{Vote::kMoving, Vote::kStatic, Vote::kUnseen, Vote::kUnseen}));
}

TEST(CollectVotes, NeedTheLeastNumberThatSeesThrough) {
  MovingObjectsConfig config;
  config.min_votes = 3;
  EXPECT_EQ(vote_of(2, 0, config), Vote::kStatic) << "seen, though too few saw through";
  EXPECT_EQ(vote_of(3, 0, config), Vote::kMoving);
  EXPECT_EQ(vote_of(0, 0, config), Vote::kUnseen);
}

TEST(CollectVotes, NeedTheFractionOfThoseThatSeeThePlace) {
  MovingObjectsConfig config;
  config.min_fraction = 0.7;
  EXPECT_EQ(vote_of(7, 3, config), Vote::kMoving);
  EXPECT_EQ(vote_of(6, 3, config), Vote::kStatic);
  EXPECT_EQ(vote_of(6, 4, config), Vote::kStatic);
  EXPECT_EQ(vote_of(14, 6, config), Vote::kMoving);
  EXPECT_EQ(vote_of(13, 6, config), Vote::kStatic);
  config.min_fraction = 1.0;
  EXPECT_EQ(vote_of(12, 0, config), Vote::kMoving);
  EXPECT_EQ(vote_of(12, 1, config), Vote::kStatic);
}

// One that sees nothing of the place is none of those that the fraction is of.
TEST(CollectVotes, DoNotCountScansFromWhichThePlaceIsHidden) {
  std::vector<ObservingScan> scans(7, scan_of_wall(20.0));
  scans.resize(27, scan_of_wall(5.0));
  EXPECT_EQ(votes_on({{10.0F, 0.0F, 0.0F}}, scans).front(), Vote::kMoving);
}

TEST(CollectVotes, LeaveOutScansBeyondTheRange) {
  MovingObjectsConfig config;
  config.max_range = 40.0;
  std::vector<ObservingScan> scans(2, scan_of_wall(20.0, {-29.0, 0.0, 0.0}));
  EXPECT_EQ(votes_on({{10.0F, 0.0F, 0.0F}}, scans, config).front(), Vote::kMoving) << "39 m";
  scans.assign(2, scan_of_wall(20.0, {-31.0, 0.0, 0.0}));
  EXPECT_EQ(votes_on({{10.0F, 0.0F, 0.0F}}, scans, config).front(), Vote::kUnseen) << "41 m";
  config.max_range = 50.0;
  EXPECT_EQ(votes_on({{10.0F, 0.0F, 0.0F}}, scans, config).front(), Vote::kMoving);
}

TEST(CollectVotes, AreGivenOnlyOnTheseIndices) {
  const PointCloud cloud = cloud_at(std::vector<Eigen::Vector3f>(6, {10.0F, 0.0F, 0.0F}));
  const std::vector<ObservingScan> scans(3, scan_of_wall(20.0));
  std::vector<Vote> expected(6, Vote::kUnseen);
  expected[1] = expected[4] = Vote::kMoving;
  EXPECT_EQ(collect_votes(cloud, Pose(), {4, 1}, pointers_to(scans), {}), expected);
  EXPECT_EQ(collect_votes(cloud, Pose(), {}, pointers_to(scans), {}),
            std::vector<Vote>(6, Vote::kUnseen));
  EXPECT_TRUE(collect_votes(PointCloud(), Pose(), {}, pointers_to(scans), {}).empty());
}

TEST(CollectVotes, SeeNothingWithoutScans) {
  EXPECT_EQ(votes_on({{10.0F, 0.0F, 0.0F}}, {}).front(), Vote::kUnseen);
  const ObservingScan blind{Pose(), RangeImage(PointCloud(), Eigen::Vector3f::Zero()), {}};
  EXPECT_EQ(votes_on({{10.0F, 0.0F, 0.0F}}, {blind, blind, blind}).front(), Vote::kUnseen);
}

/// A dozen scans from different places, of walls at different distances, and many points.
struct ManyVotes {
  ManyVotes() {
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> wall(8.0, 25.0), aside(-3.0, 3.0);
    for (int i = 0; i < 13; ++i) {
      scans.push_back(scan_of_wall(wall(engine), {aside(engine), aside(engine), 0.0}));
    }
    std::uniform_real_distribution<float> x(5.0F, 28.0F), y(-4.0F, 4.0F), z(-1.0F, 1.0F);
    std::vector<Eigen::Vector3f> positions;
    for (int i = 0; i < 3000; ++i) {
      const float ahead = x(engine);
      positions.emplace_back(ahead, y(engine), z(engine));
    }
    cloud = cloud_at(positions);
  }
  std::vector<Vote> votes(const std::vector<const ObservingScan*>& observers) const {
    return collect_votes(cloud, Pose(), all_of(cloud), observers, {});
  }

  std::vector<ObservingScan> scans;
  PointCloud cloud;
};

// Observers are left out once they cannot change the vote, and points are processed in portions.
TEST(CollectVotes, DoNotDependOnTheOrderOfTheScans) {
  const ManyVotes many;
  auto observers = pointers_to(many.scans);
  const std::vector<Vote> votes = many.votes(observers);
  for (const Vote vote : {Vote::kStatic, Vote::kMoving, Vote::kUnseen}) {
    EXPECT_GT(std::count(votes.begin(), votes.end(), vote), 50);
  }
  std::mt19937 engine(1);
  for (int round = 0; round < 5; ++round) {
    std::shuffle(observers.begin(), observers.end(), engine);
    EXPECT_EQ(many.votes(observers), votes) << round;
  }
}

TEST(CollectVotes, OnManyPointsAreThoseOnEach) {
  const ManyVotes many;
  const auto observers = pointers_to(many.scans);
  const std::vector<Vote> votes = many.votes(observers);
  for (std::uint32_t i = 0; i < many.cloud.size(); i += 7) {
    EXPECT_EQ(collect_votes(many.cloud, Pose(), {i}, observers, {})[i], votes[i]) << i;
  }
}

// Where the map begins is arbitrary.
TEST(CollectVotes, DoNotChangeIfTheWholeMapIsMoved) {
  const Pose moved{exp_so3({0.1, -0.2, 2.5}), {400.0, -700.0, 30.0}};
  const auto scan_at = [](double wall, const Pose& T) {
    return scan_of_wall(wall, {0.0, 1.0, 0.0}, T);
  };
  const PointCloud cloud = cloud_at({{10.0F, 0.0F, 0.0F}, {20.0F, 0.0F, 0.0F}});
  for (const Pose& T : {Pose(), moved}) {
    const std::vector<ObservingScan> scans(3, scan_at(20.0, T));
    EXPECT_EQ(collect_votes(cloud, T, all_of(cloud), pointers_to(scans), {}),
              (std::vector<Vote>{Vote::kMoving, Vote::kStatic}));
  }
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
