// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <utility>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::pipeline {

/// Clouds that nobody needs any more, for the sake of their memory: fresh pages for each scan would
/// take a good part of the time that reading it takes. Any threads.
class SpareClouds {
 public:
  /// A cloud of any content, empty if there is none to spare.
  PointCloud take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (clouds_.empty()) return {};
    PointCloud cloud = std::move(clouds_.back());
    clouds_.pop_back();
    return cloud;
  }
  void give(PointCloud&& cloud) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (clouds_.size() < kMost) clouds_.push_back(std::move(cloud));
  }

 private:
  static constexpr std::size_t kMost = 4;

  std::mutex mutex_;
  std::vector<PointCloud> clouds_;
};

}  // namespace lidar_mapping::pipeline
