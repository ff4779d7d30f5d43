// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <utility>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::pipeline {

/// Pool of clouds that are not needed any more, whose memory is reused: allocating new pages for
/// each scan would take a considerable part of the time of reading. Safe for any threads.
class CloudPool {
 public:
  /// A cloud of arbitrary content to be overwritten; empty if the pool is empty.
  PointCloud acquire() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (clouds_.empty()) return {};
    PointCloud cloud = std::move(clouds_.back());
    clouds_.pop_back();
    return cloud;
  }
  /// Returns a cloud to the pool.
  void release(PointCloud&& cloud) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (clouds_.size() < kMaxClouds) clouds_.push_back(std::move(cloud));
  }

 private:
  /// Chosen: a few scans are under way at a time, more would be idle memory.
  static constexpr std::size_t kMaxClouds = 4;

  std::mutex mutex_;
  std::vector<PointCloud> clouds_;
};

}  // namespace lidar_mapping::pipeline
