// SPDX-License-Identifier: BSD-3-Clause
#include "files/point_spool.hpp"

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kBuffer = 64 * 1024;  // points, 1.3 MB; chosen: the disk is fast with that

}  // namespace

void PointSpool::add(const StoredPoint& point) {
  buffer_.push_back(point);
  if (buffer_.size() < kBuffer) return;
  parts_.put(parts_.size(), buffer_);
  stored_ += buffer_.size();
  buffer_.clear();
}

void PointSpool::for_each(
    const std::function<void(std::size_t number, const StoredPoint&)>& visit) const {
  std::size_t number = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    for (const StoredPoint& point : parts_.get(i)) visit(number++, point);
  }
  for (const StoredPoint& point : buffer_) visit(number++, point);
}

void PointSpool::append_to(std::vector<StoredPoint>& points) const {
  points.reserve(points.size() + size());
  for_each([&](std::size_t, const StoredPoint& point) { points.push_back(point); });
}

}  // namespace lidar_mapping::map
