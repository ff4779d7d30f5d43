// SPDX-License-Identifier: BSD-3-Clause
// Who else passed by, and marks of points.

#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "marks.hpp"
#include "visits/other_visits.hpp"

namespace lidar_mapping::moving_objects {
namespace {

using Positions = std::vector<OtherVisits::Position>;
using Near = std::map<std::uint32_t, Positions>;

constexpr Stamp kDay = 86'400 * kNanosecondsPerSecond;

/// Key frames of a drive along x that is repeated from day to day.
class DailyDrive {
 public:
  void add(int day, double x, double y = 0.0, double z = 0.0) {
    KeyFramePose pose;
    pose.index = static_cast<KeyFrameIndex>(poses_.size());
    pose.stamp = day * kDay + static_cast<Stamp>(poses_.size()) * kNanosecondsPerSecond;
    pose.T_map_base.translation = {x, y, z};
    poses_.push_back(pose);
  }
  Near near(OtherVisits::Position position) const {
    return OtherVisits(poses_, Visits(poses_)).near(position);
  }

 private:
  std::vector<KeyFramePose> poses_;
};

TEST(OtherVisits, PassedByWithinFiftyMetres) {
  DailyDrive drive;
  drive.add(0, 0.0);
  for (const double x : {-50.1, -50.0, 50.0, 50.1}) drive.add(1, x);
  drive.add(2, 30.0, -40.0);
  drive.add(2, 30.0, -40.1);
  drive.add(3, 0.0, 0.0, 60.0);
  EXPECT_EQ(drive.near(0), (Near{{1, {2, 3}}, {2, {5}}})) << "by the distance in space";
  EXPECT_EQ(drive.near(7), Near());
}

TEST(OtherVisits, DoNotLookFromTheOwnVisit) {
  DailyDrive drive;
  drive.add(0, 0.0);
  drive.add(0, 3.0);
  drive.add(1, 3.0);
  EXPECT_EQ(drive.near(0), (Near{{1, {2}}}));
  EXPECT_EQ(drive.near(2), (Near{{0, {1, 0}}})) << "the nearest first";
}

TEST(OtherVisits, LookFromTwoMetresApart) {
  DailyDrive drive;
  drive.add(0, 0.0);
  for (const double x : {6.0, 1.0, 2.9, 3.0, 5.5, -0.5}) drive.add(1, x);
  // -0.5 m is the nearest, so 1 m is too near to it; then 2.9 m, 3 m no more, 5.5 m, and not 6 m.
  EXPECT_EQ(drive.near(0), (Near{{1, {6, 3, 5}}}));
}

TEST(OtherVisits, LookFromAsManyPlacesEachAndFromTheFirstOfEqualOnes) {
  DailyDrive drive;
  drive.add(0, 0.0);
  drive.add(1, 1.0);
  drive.add(2, -1.5);
  drive.add(2, 1.5);
  drive.add(1, -1.0);
  EXPECT_EQ(drive.near(0), (Near{{1, {1, 4}}, {2, {2, 3}}}))
      << "visits do not take places from each other";
}

PointCloud numbered(std::size_t points) {
  PointCloud cloud;
  for (std::size_t i = 0; i < points; ++i) {
    cloud.points.push_back({0.0F, 0.0F, 0.0F, static_cast<float>(i)});
  }
  return cloud;
}

std::vector<int> numbers_of(const PointCloudPtr& cloud) {
  std::vector<int> result;
  for (const Point& point : cloud->points) result.push_back(static_cast<int>(point.intensity));
  return result;
}

TEST(Marks, PartACloud) {
  const PointCloud cloud = numbered(5);
  EXPECT_EQ(numbers_of(marked_points(cloud, {0, 3})), (std::vector<int>{0, 3}));
  EXPECT_EQ(numbers_of(unmarked_points(cloud, {0, 3})), (std::vector<int>{1, 2, 4}));
  EXPECT_EQ(numbers_of(unmarked_points(cloud, {4})), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_TRUE(marked_points(cloud, {})->empty());
  EXPECT_EQ(unmarked_points(cloud, {})->size(), 5U);
  EXPECT_TRUE(unmarked_points(cloud, {0, 1, 2, 3, 4})->empty());
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
