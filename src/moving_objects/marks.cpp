// SPDX-License-Identifier: BSD-3-Clause
#include "marks.hpp"

namespace lidar_mapping::moving_objects {

namespace {

PointCloudPtr points_that_are(bool wanted, const PointCloud& cloud, const Marks& marks) {
  auto result = std::make_shared<PointCloud>();
  result->points.reserve(wanted ? marks.size() : cloud.size() - marks.size());
  auto next = marks.begin();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool is_marked = next != marks.end() && *next == i;
    if (is_marked) ++next;
    if (is_marked == wanted) result->points.push_back(cloud.points[i]);
  }
  return result;
}

}  // namespace

PointCloudPtr marked_points(const PointCloud& cloud, const Marks& marks) {
  return points_that_are(true, cloud, marks);
}

PointCloudPtr unmarked_points(const PointCloud& cloud, const Marks& marks) {
  return points_that_are(false, cloud, marks);
}

}  // namespace lidar_mapping::moving_objects
