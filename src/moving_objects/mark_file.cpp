// SPDX-License-Identifier: BSD-3-Clause
#include "mark_file.hpp"

namespace lidar_mapping::moving_objects {

namespace {

constexpr std::size_t kSize = sizeof(Marks::value_type);

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

void MarkFile::put(std::size_t position, const Marks& marks) {
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  file_->write(end_ * kSize, marks.data(), marks.size() * kSize);
  spans_[position] = {end_, marks.size()};
  end_ += marks.size();
}

Marks MarkFile::get(std::size_t position) const {
  const Span& span = spans_.at(position);
  Marks marks(span.count);
  file_->read(span.begin * kSize, marks.data(), marks.size() * kSize);
  return marks;
}

}  // namespace lidar_mapping::moving_objects
