// SPDX-License-Identifier: BSD-3-Clause
#include "files/point_spool.hpp"

#include <algorithm>

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kBuffer = 64 * 1024;  // points, 1.3 MB; chosen: the disk is fast with that

}  // namespace

void PointSpool::add(const StoredPoint& point) {
  buffer_.push_back(point);
  if (buffer_.size() == kBuffer) store();
}

void PointSpool::store() {
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  file_->write(stored_ * sizeof(StoredPoint), buffer_.data(), buffer_.size() * sizeof(StoredPoint));
  stored_ += buffer_.size();
  buffer_.clear();
}

void PointSpool::for_each(
    const std::function<void(std::size_t number, const StoredPoint&)>& visit) const {
  std::vector<StoredPoint> part(std::min(stored_, kBuffer));
  std::size_t number = 0;
  while (number < stored_) {
    const std::size_t count = std::min(kBuffer, stored_ - number);
    file_->read(number * sizeof(StoredPoint), part.data(), count * sizeof(StoredPoint));
    for (std::size_t i = 0; i < count; ++i) visit(number++, part[i]);
  }
  for (const StoredPoint& point : buffer_) visit(number++, point);
}

void PointSpool::append_to(std::vector<StoredPoint>& points) const {
  points.reserve(points.size() + size());
  for_each([&](std::size_t, const StoredPoint& point) { points.push_back(point); });
}

}  // namespace lidar_mapping::map
