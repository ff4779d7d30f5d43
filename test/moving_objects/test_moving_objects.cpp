// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include "box_street.hpp"

namespace lidar_mapping::moving_objects {
namespace {

constexpr KeyFrameIndex kKeyFrames = 30;
const Eigen::Vector3d kSensor(0.5, 0.0, 1.8);

/// A street with walls, a parked car, a pole, and a car or truck that drives towards the vehicle.
class Street : public CloudSource {
 public:
  explicit Street(double height = 1.5) : height_(height) {
    for (KeyFrameIndex index = 0; index < kKeyFrames; ++index) {
      Pose pose;
      pose.translation.x() = 1.0 * index;
      poses.poses.push_back({index, Stamp{index}, pose});
      clouds_[index] = scan(pose, moving_car(index));
    }
  }

  Box moving_car(KeyFrameIndex index) const {
    const double x = 45.0 - 1.2 * index;
    return {{x, 2.0, 0.0}, {x + 4.0, 3.8, height_}};
  }

  PointCloudPtr cloud(KeyFrameIndex index) override { return clouds_.at(index); }

  /// Whether a point of this key frame is on the moving car, well above the ground.
  bool on_moving_car(KeyFrameIndex index, const Point& point) const {
    const Eigen::Vector3d p =
        point.position().cast<double>() + Eigen::Vector3d(1.0 * index, 0.0, 0.0);
    return moving_car(index).contains(p, 0.01) && p.z() > 0.15;
  }

  KeyFramePoses poses;

 private:
  static PointCloudPtr scan(const Pose& T_map_base, const Box& car) {
    std::vector<Box> boxes = street_boxes();
    boxes.push_back({{12.0, -5.5, 0.0}, {16.0, -3.8, 1.5}});
    boxes.push_back(car);
    return scan_of_boxes(boxes, T_map_base, kSensor);
  }

  const double height_;  // m
  std::map<KeyFrameIndex, PointCloudPtr> clouds_;
};

struct PointCounts {
  double moving = 0.0;
  double static_points = 0.0;
};

PointCounts count(const Street& street, const PointCloud& cloud, KeyFrameIndex index) {
  PointCounts counts;
  for (const Point& point : cloud.points) {
    (street.on_moving_car(index, point) ? counts.moving : counts.static_points) += 1.0;
  }
  return counts;
}

class MovingObjectsTest : public testing::TestWithParam<double> {};

TEST_P(MovingObjectsTest, AreRemovedAndStaticPointsStay) {
  Street street(GetParam());
  StaticClouds clean(street, street.poses, kSensor);
  PointCounts before;
  PointCounts after;
  for (KeyFrameIndex index = 5; index < 25; ++index) {
    const PointCounts all = count(street, *street.cloud(index), index);
    const PointCounts kept = count(street, *clean.cloud(index), index);
    before.moving += all.moving;
    before.static_points += all.static_points;
    after.moving += kept.moving;
    after.static_points += kept.static_points;
  }
  ASSERT_GT(before.moving, 1000.0);
  EXPECT_LT(after.moving / before.moving, 0.05);
  EXPECT_GT(after.static_points / before.static_points, 0.999);
}

INSTANTIATE_TEST_SUITE_P(HeightOfCarAndTruck, MovingObjectsTest, testing::Values(1.5, 3.6));

/// Clouds in which raindrops end some of the rays, most of them near the sensor.
class Rain : public CloudSource {
 public:
  Rain(Street& street, double fraction) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    std::exponential_distribution<float> beyond(1.0F / 6.0F);
    for (const KeyFramePose& pose : street.poses.poses) {
      auto cloud = std::make_shared<PointCloud>(*street.cloud(pose.index));
      for (Point& point : cloud->points) {
        if (chance(engine) > fraction) continue;
        const Eigen::Vector3f sensor = kSensor.cast<float>();
        const Eigen::Vector3f ray = point.position() - sensor;
        const float range = 1.5F + beyond(engine);
        if (range > ray.norm() - 0.5F) continue;
        const Eigen::Vector3f p = sensor + ray * (range / ray.norm());
        point = {p.x(), p.y(), p.z(), kDrop};
      }
      clouds_[pose.index] = cloud;
    }
  }

  PointCloudPtr cloud(KeyFrameIndex index) override { return clouds_.at(index); }

  static constexpr float kDrop = 7.0F;

 private:
  std::map<KeyFrameIndex, PointCloudPtr> clouds_;
};

TEST(MovingObjects, RaindropsAreRemovedAndSurfacesStay) {
  Street street;
  Rain rain(street, 0.03);
  StaticClouds clean(rain, street.poses, kSensor);
  std::map<bool, double> all, removed_count;  // true: raindrops; false: static points
  for (KeyFrameIndex index = 5; index < 25; ++index) {
    const PointCloudPtr cloud = rain.cloud(index);
    for (const Point& point : cloud->points) {
      if (!street.on_moving_car(index, point)) all[point.intensity == Rain::kDrop] += 1.0;
    }
    const PointCloudPtr removed = clean.removed(index);
    for (const Point& point : removed->points) {
      if (!street.on_moving_car(index, point)) removed_count[point.intensity == Rain::kDrop] += 1.0;
    }
  }
  ASSERT_GT(all[true], 5000.0);
  EXPECT_GT(removed_count[true] / all[true], 0.97) << "0.96 where only things go";
  EXPECT_LT(removed_count[false] / all[false], 0.001);
}

TEST(MovingObjects, StaticAndRemovedPointsAreTheWholeCloud) {
  Street street;
  StaticClouds clean(street, street.poses, kSensor);
  EXPECT_EQ(clean.cloud(10)->size() + clean.removed(10)->size(), street.cloud(10)->size());
}

TEST(MovingObjects, AreNotWhatStoodElsewhereAnotherDay) {
  TwoDays days(10, 1.0, {{8.0, -5.5, 0.0}, {12.0, -3.8, 1.5}}, true);
  StaticClouds clean(days, days.poses, days.p_base_sensor);
  for (const KeyFramePose& pose : days.poses.poses) {
    EXPECT_EQ(clean.removed(pose.index)->size(), 0U) << pose.index;
  }
}

bool are_equal(const PointCloud& a, const PointCloud& b) {
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                    [](const Point& p, const Point& q) { return p.position() == q.position(); });
}

TEST(MovingObjects, DoNotDependOnThreadsOrOrderOfCalls) {
  Street street;
  MovingObjectsConfig config;
  config.threads = 1;
  StaticClouds one(street, street.poses, kSensor, config);
  config.threads = 3;
  StaticClouds three(street, street.poses, kSensor, config);
  for (KeyFrameIndex asked = 0; asked < kKeyFrames; ++asked) {
    const KeyFrameIndex index = kKeyFrames - 1 - asked;
    EXPECT_TRUE(are_equal(*one.removed(index), *three.removed(index))) << index;
    EXPECT_GT(one.removed(asked)->size(), 0U);
    EXPECT_TRUE(are_equal(*one.removed(asked), *three.removed(asked))) << asked;
  }
}

TEST(MovingObjects, AreTheSameForSeveralCloudsAndForEach) {
  Street street;
  StaticClouds clean(street, street.poses, kSensor);
  StaticClouds together(street, street.poses, kSensor);
  const std::vector<KeyFrameIndex> indices = {20, 3, 17};
  const std::vector<PointCloudPtr> clouds = together.clouds(indices, 2);
  ASSERT_EQ(clouds.size(), indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    EXPECT_TRUE(are_equal(*clouds[i], *clean.cloud(indices[i]))) << indices[i];
  }
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
