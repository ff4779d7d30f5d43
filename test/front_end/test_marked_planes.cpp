// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "local_map/marked_planes.hpp"
#include "sampled_points.hpp"

namespace lidar_mapping::front_end {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Points every 0.5 m on the side of a truck, 3 m to the left of the sensor.
Points side(float from, float to) {
  Points points;
  for (float x = from; x < to; x += 0.5F) {
    for (float z = -1.0F; z <= 2.0F; z += 0.5F) points.emplace_back(x, 3.0F, z);
  }
  return points;
}

/// Points every 0.5 m on the ground, 1.7 m below the sensor.
Points ground() {
  Points points;
  for (float x = -10.0F; x < 10.0F; x += 0.5F) {
    for (float y = -9.75F; y < 10.0F; y += 0.5F) points.emplace_back(x, y, -1.7F);
  }
  return points;
}

Points joined(Points points, const Points& others) {
  points.insert(points.end(), others.begin(), others.end());
  return points;
}

/// Marks from which mark_planes() starts: the points for which the condition holds.
template <typename Condition>
PointMarks marks_where(const Points& points, const Condition& is_marked) {
  PointMarks marks;
  for (const Eigen::Vector3f& p : points) marks.push_back(is_marked(p) ? 1 : 0);
  return marks;
}

std::ptrdiff_t count(const PointMarks& marks) { return std::count(marks.begin(), marks.end(), 1); }

bool is_side(const Eigen::Vector3f& p) { return p.y() == 3.0F && p.z() >= -1.0F; }

TEST(MarkedPlanes, AreMarkedAsAWhole) {
  const Points points = joined(side(-9.0F, 9.0F), ground());
  PointMarks marks = marks_where(points, [](const auto& p) { return is_side(p) && p.x() >= 7.0F; });
  mark_planes(sampled(points), marks);
  EXPECT_EQ(marks, marks_where(points, is_side));
}

TEST(MarkedPlanes, EndAtAGap) {
  const Points points = joined(side(-9.0F, -4.0F), side(0.0F, 9.0F));
  PointMarks marks = marks_where(points, [](const auto& p) { return p.x() >= 7.0F; });
  mark_planes(sampled(points), marks);
  EXPECT_EQ(marks, marks_where(points, [](const auto& p) { return p.x() >= 0.0F; }));
}

TEST(MarkedPlanes, NeedATenthOfTheirPoints) {
  const Points points = side(-9.0F, 9.0F);  // 252
  for (const float front : {6.5F, 7.5F}) {  // 35 and 21 points
    PointMarks marks = marks_where(points, [&](const auto& p) { return p.x() >= front; });
    mark_planes(sampled(points), marks);
    EXPECT_EQ(count(marks), front == 6.5F ? 252 : 21);
  }
}

TEST(MarkedPlanes, NeedTwelvePoints) {
  const Points points = side(-2.0F, 2.0F);
  for (const std::size_t marked : {11U, 12U}) {
    PointMarks marks(points.size(), 0);
    std::fill_n(marks.begin(), marked, 1);
    mark_planes(sampled(points), marks);
    EXPECT_EQ(count(marks), marked == 12U ? 56 : 11);
  }
}

// A truck on each side: the second plane is looked for among the marks that the first one leaves.
TEST(MarkedPlanes, AreSeveral) {
  Points points = side(-9.0F, 9.0F);
  for (const Eigen::Vector3f& p : side(-9.0F, 9.0F)) points.emplace_back(p.x(), -p.y(), p.z());
  PointMarks marks = marks_where(points, [](const auto& p) { return p.x() >= 6.0F; });
  mark_planes(sampled(points), marks);
  EXPECT_EQ(count(marks), static_cast<std::ptrdiff_t>(points.size()));
}

TEST(MarkedPlanes, LeavePointsThatLieOnNone) {
  Points points = ground();
  const std::size_t on_ground = points.size();
  for (int i = 0; i < 20; ++i) {
    const auto k = static_cast<float>(i);
    points.emplace_back(3.0F + 0.9F * k, 0.05F * k * k, 0.01F * k * k * k);  // on a curve
  }
  PointMarks marks(points.size(), 0);
  std::fill(marks.begin() + static_cast<std::ptrdiff_t>(on_ground), marks.end(), 1);
  const PointMarks before = marks;
  mark_planes(sampled(points), marks);
  EXPECT_EQ(marks, before);
}

TEST(MarkedPlanes, AreNoneOfPointsOnALine) {
  const Points points = ground();
  PointMarks marks = marks_where(points, [](const auto& p) { return p.y() == 0.25F; });
  ASSERT_EQ(count(marks), 40);
  const PointMarks before = marks;
  mark_planes(sampled(points), marks);
  EXPECT_EQ(marks, before);
  const Points line(points.begin(), points.begin() + 30);  // all of them
  marks.assign(200, 0);
  std::fill_n(marks.begin(), 30, 1);
  Points with_line = line;
  for (int i = 0; i < 170; ++i) with_line.emplace_back(0.1F * static_cast<float>(i), 3.0F, 2.0F);
  mark_planes(sampled(with_line), marks);
  EXPECT_EQ(count(marks), 30);
}

TEST(MarkedPlanes, AreNoneWithoutMarks) {
  PointMarks marks;
  mark_planes({}, marks);
  EXPECT_TRUE(marks.empty());
  marks.assign(ground().size(), 0);
  mark_planes(sampled(ground()), marks);
  EXPECT_EQ(count(marks), 0);
}

}  // namespace
}  // namespace lidar_mapping::front_end
