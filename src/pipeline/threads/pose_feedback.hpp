// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::pipeline {

/// All poses of the drive; null if none has moved.
using MovedPoses = std::shared_ptr<const KeyFramePoses>;

/// Passes poses from the graph back to the loop search: step n of the search uses the poses after
/// step n - kLag of the graph, however fast both are.
class PoseFeedback {
 public:
  /// Steps; chosen: a shorter lag makes the search wait, a longer one searches with older poses.
  static constexpr std::size_t kLag = 4;

  /// Reports that the graph has finished its next step.
  void add_step(MovedPoses moved) {
    const std::lock_guard<std::mutex> lock(mutex_);
    steps_.push_back(std::move(moved));
    changed_.notify_all();
  }
  /// Poses for the next step of the search; waits for the graph. Null also if the graph has failed.
  MovedPoses wait_for_step() {
    std::unique_lock<std::mutex> lock(mutex_);
    if (++requested_ <= kLag) return nullptr;
    changed_.wait(lock, [&] { return !steps_.empty() || closed_; });
    if (steps_.empty()) return nullptr;
    MovedPoses moved = std::move(steps_.front());
    steps_.pop_front();
    return moved;
  }
  /// Reports that the graph has failed, so that the search does not wait any longer.
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<MovedPoses> steps_;
  std::size_t requested_ = 0;
  bool closed_ = false;
};

}  // namespace lidar_mapping::pipeline
