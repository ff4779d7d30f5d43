// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/current_clouds.hpp"

#include "box_street.hpp"

namespace lidar_mapping::moving_objects {
namespace {

constexpr KeyFrameIndex kKeyFramesPerVisit = 25;
constexpr Stamp kDay = 86'400'000'000'000;  // ns
const Eigen::Vector3d kSensor(0.5, 0.0, 1.8);
const Box kCar{{12.0, -5.5, 0.0}, {16.0, -3.8, 1.5}};
const Box kHouse{{25.0, 4.0, 0.0}, {31.0, 7.9, 5.0}};
const Box kHut{{30.0, -7.0, 0.0}, {33.0, -5.0, 2.2}};

/// A street that is driven along once a day; on each day other things stand there.
class ChangingStreet : public CloudSource {
 public:
  explicit ChangingStreet(const std::vector<std::vector<Box>>& things_of_days) {
    KeyFrameIndex index = 0;
    for (std::size_t day = 0; day < things_of_days.size(); ++day) {
      std::vector<Box> boxes = street_boxes();
      boxes.insert(boxes.end(), things_of_days[day].begin(), things_of_days[day].end());
      for (KeyFrameIndex i = 0; i < kKeyFramesPerVisit; ++i, ++index) {
        Pose pose;
        // each day a little further left, and not exactly where it was
        pose.translation = {1.5 * i + 0.3 * static_cast<double>(day),
                            0.4 * static_cast<double>(day), 0.0};
        const Stamp stamp = static_cast<Stamp>(day) * kDay + Stamp{i} * 200'000'000;
        poses.poses.push_back({index, stamp, pose});
        clouds_[index] = scan_of_boxes(boxes, pose, kSensor);
      }
    }
  }

  PointCloudPtr cloud(KeyFrameIndex index) override { return clouds_.at(index); }

  /// Number of points of these clouds on a box, well above the ground.
  std::size_t points_on(const Box& box, CloudSource& clouds) const {
    return count(clouds, [&](const Eigen::Vector3d& p_map) {
      return box.contains(p_map, 0.02) && p_map.z() > 0.15;
    });
  }

  /// Number of points of these clouds that are on none of the boxes.
  std::size_t points_beside(const std::vector<Box>& boxes, CloudSource& clouds) const {
    return count(clouds, [&](const Eigen::Vector3d& p_map) {
      return std::none_of(boxes.begin(), boxes.end(),
                          [&](const Box& box) { return box.contains(p_map, 0.02); });
    });
  }

  KeyFramePoses poses;

 private:
  template <typename Predicate>
  std::size_t count(CloudSource& clouds, const Predicate& is_counted) const {
    std::size_t sum = 0;
    for (const KeyFramePose& pose : poses.poses) {
      const PointCloudPtr cloud = clouds.cloud(pose.index);
      for (const Point& point : cloud->points) {
        sum += is_counted(pose.T_map_base * point.position().cast<double>()) ? 1 : 0;
      }
    }
    return sum;
  }

  std::map<KeyFrameIndex, PointCloudPtr> clouds_;
};

CurrentClouds current_of(ChangingStreet& street) {
  return {street, street, street.poses, kSensor, {}, testing::TempDir()};
}

TEST(CurrentClouds, LeaveOutWhatLaterVisitsLookThrough) {
  ChangingStreet street({{kCar, kHouse}, {kCar}, {}});
  CurrentClouds current = current_of(street);
  ASSERT_EQ(current.visits().visits().size(), 3U);
  for (const Box& box : {kCar, kHouse}) {
    const std::size_t before = street.points_on(box, street);
    ASSERT_GT(before, 3000U);
    EXPECT_LT(street.points_on(box, current), before / 20) << "at least 95 % are gone";
  }
  const std::size_t all = street.points_beside({kCar, kHouse}, street);
  EXPECT_LT(all - street.points_beside({kCar, kHouse}, current), all / 1000)
      << "of what stands less than 0.1 % are lost";
}

TEST(CurrentClouds, KeepWhatCameAndWhatCameBack) {
  ChangingStreet street({{kCar}, {kHut}, {kCar, kHut}});
  CurrentClouds current = current_of(street);
  EXPECT_EQ(street.points_on(kHut, current), street.points_on(kHut, street));
  // But for the points at its edges that the last visit did not observe again.
  EXPECT_GT(street.points_on(kCar, current), 95 * street.points_on(kCar, street) / 100);
}

TEST(CurrentClouds, ListEachChangeWithItsVisitsAndItsPlace) {
  ChangingStreet street({{kCar}, {kCar, kHut}, {kHut}});
  const std::vector<Change> changes = current_of(street).changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].kind, ChangeKind::kAppeared);
  EXPECT_EQ(changes[0].absent, 0U);
  EXPECT_EQ(changes[0].present, 1U);
  EXPECT_EQ(changes[1].kind, ChangeKind::kDisappeared);
  EXPECT_EQ(changes[1].absent, 2U);
  EXPECT_EQ(changes[1].present, 1U);
  const std::vector<Box> expected = {kHut, kCar};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    // Only the faces towards the street are seen.
    EXPECT_LT(
        (0.5 * (changes[i].low + changes[i].high) - 0.5 * (expected[i].low + expected[i].high))
            .norm(),
        1.0);
    EXPECT_NEAR((changes[i].high - changes[i].low).x(), (expected[i].high - expected[i].low).x(),
                0.6);
  }
}

TEST(CurrentClouds, ListNoChangesForOneVisitOrEqualOnes) {
  ChangingStreet once({{kCar}});
  CurrentClouds alone = current_of(once);
  EXPECT_TRUE(alone.changes().empty());
  ChangingStreet twice({{kCar, kHut}, {kCar, kHut}});
  CurrentClouds equal = current_of(twice);
  EXPECT_TRUE(equal.changes().empty());
  EXPECT_EQ(equal.outdated(), 0U);
}

TEST(Visits, ArePartedByPauses) {
  const Stamp second = 1'000'000'000;
  std::vector<KeyFramePose> poses;
  for (const Stamp stamp : {1000 * second, 0 * second, 599 * second, 1700 * second}) {
    poses.push_back({static_cast<KeyFrameIndex>(poses.size()), stamp, Pose()});
  }
  const Visits visits(poses);
  ASSERT_EQ(visits.visits().size(), 2U);
  EXPECT_EQ(visits.visit_of(0), 0U);
  EXPECT_EQ(visits.visit_of(1), 0U);
  EXPECT_EQ(visits.visit_of(3), 1U);
  EXPECT_EQ(visits.visits()[0].begin, 0);
  EXPECT_EQ(visits.visits()[0].end, 1000 * second);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
