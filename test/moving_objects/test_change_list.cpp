// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/change_list.hpp"

namespace lidar_mapping::moving_objects {
namespace {

/// Adds the points of a wall of `length` by 1 m that begins at this corner.
void add_wall(ChangeList& list, const Eigen::Vector3d& corner, double length,
              const PointChange& change) {
  for (double x = 0.05; x < length; x += 0.1) {
    for (double z = 0.05; z < 1.0; z += 0.1) {
      list.add(corner + Eigen::Vector3d(x, 0.1, z), change);
    }
  }
}

TEST(ChangeList, JoinsWhatTouches) {
  ChangeList list;
  add_wall(list, {1.0, 2.0, 0.0}, 2.0, {ChangeKind::kAppeared, 1, 3});
  add_wall(list, {3.0, 2.0, 0.0}, 1.0, {ChangeKind::kAppeared, 1, 2});
  add_wall(list, {9.0, 2.0, 0.0}, 1.0, {ChangeKind::kAppeared, 1, 2});
  const std::vector<Change> changes = list.changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].present, 2U) << "the first visit in which a part of it was seen";
  EXPECT_TRUE(changes[0].low.isApprox(Eigen::Vector3d(1.0, 2.0, 0.0)));
  EXPECT_TRUE(changes[0].high.isApprox(Eigen::Vector3d(4.0, 2.25, 1.0)));
  EXPECT_EQ(changes[0].points.size(), 48U);
  EXPECT_NEAR(changes[1].low.x(), 9.0, 1e-12);
}

// A map whose odometry began at UTM coordinates.
TEST(ChangeList, KnowsPlacesFarFromTheOrigin) {
  ChangeList list;
  const Eigen::Vector3d corner(432'000.0, 5'412'000.0, -3.0);
  add_wall(list, corner, 1.0, {ChangeKind::kAppeared, 0, 1});
  const std::vector<Change> changes = list.changes();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].low, corner);
  EXPECT_EQ(changes[0].high, Eigen::Vector3d(corner + Eigen::Vector3d(1.0, 0.25, 1.0)));
}

TEST(ChangeList, KeepsApartWhatHappenedAtOtherTimes) {
  ChangeList list;
  add_wall(list, {0.0, 0.0, 0.0}, 1.0, {ChangeKind::kDisappeared, 4, 1});
  add_wall(list, {1.0, 0.0, 0.0}, 1.0, {ChangeKind::kDisappeared, 3, 1});
  add_wall(list, {2.0, 0.0, 0.0}, 1.0, {ChangeKind::kAppeared, 3, 4});
  const std::vector<Change> changes = list.changes();
  ASSERT_EQ(changes.size(), 3U);
  EXPECT_EQ(changes[0].kind, ChangeKind::kAppeared);
  EXPECT_EQ(changes[1].absent, 3U);
  EXPECT_EQ(changes[2].absent, 4U);
}

TEST(ChangeList, TakesTheLastVisitInWhichSomethingWasThere) {
  ChangeList list;
  list.add({0.1, 0.1, 0.1}, {ChangeKind::kDisappeared, 5, 1});
  add_wall(list, {0.0, 0.0, 0.0}, 1.0, {ChangeKind::kDisappeared, 5, 3});
  ASSERT_EQ(list.changes().size(), 1U);
  EXPECT_EQ(list.changes()[0].present, 3U);
}

TEST(ChangeList, LeavesOutWhatIsSmall) {
  ChangeList list;
  add_wall(list, {0.0, 0.0, 0.0}, 0.5, {ChangeKind::kAppeared, 0, 1});
  EXPECT_EQ(list.changes().size(), 1U) << "1 m high";
  ChangeList small;
  for (double z = 0.1; z < 1.0; z += 0.25) small.add({0.1, 0.1, z}, {ChangeKind::kAppeared, 0, 1});
  EXPECT_TRUE(small.changes().empty()) << "four voxels are a beam through a hedge";
  ChangeList edge;
  for (double along = 0.1; along < 4.0; along += 0.2) {
    edge.add({along, along, 3.1}, {ChangeKind::kAppeared, 0, 1});
    edge.add({along, along, 3.3}, {ChangeKind::kAppeared, 0, 1});
  }
  EXPECT_TRUE(edge.changes().empty()) << "a level line is the edge of a roof";
  ChangeList plate;
  for (double x = 0.1; x < 2.0; x += 0.2) {
    for (double y = 0.1; y < 1.4; y += 0.2) plate.add({x, y, 3.1}, {ChangeKind::kAppeared, 0, 1});
  }
  EXPECT_EQ(plate.changes().size(), 1U) << "a canopy";
  ChangeList cube;
  for (double x : {0.1, 0.3}) {
    for (double y : {0.1, 0.3}) {
      for (double z : {0.1, 0.3}) cube.add({x, y, z}, {ChangeKind::kAppeared, 0, 1});
    }
  }
  EXPECT_TRUE(cube.changes().empty()) << "half a metre along each edge";
}

TEST(ChangeList, MergesOthersAsIfTheirPointsWereItsOwn) {
  ChangeList all, part, other;
  for (ChangeList* list : {&all, &part}) {
    add_wall(*list, {0.0, 0.0, 0.0}, 1.0, {ChangeKind::kAppeared, 0, 2});
  }
  for (ChangeList* list : {&all, &other}) {
    add_wall(*list, {0.75, 0.0, 0.0}, 1.0, {ChangeKind::kAppeared, 0, 1});
  }
  part.add(other);
  ASSERT_EQ(part.changes().size(), 1U);
  ASSERT_EQ(all.changes().size(), 1U);
  EXPECT_EQ(part.changes()[0].points.size(), all.changes()[0].points.size());
  EXPECT_EQ(part.changes()[0].present, 1U);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
