// SPDX-License-Identifier: BSD-3-Clause
#include "threads/pose_feedback.hpp"

#include <utility>

namespace lidar_mapping::pipeline {

void PoseFeedback::add_step(MovedPoses moved) {
  const std::lock_guard<std::mutex> lock(mutex_);
  steps_.push_back(std::move(moved));
  changed_.notify_all();
}

MovedPoses PoseFeedback::wait_for_step() {
  std::unique_lock<std::mutex> lock(mutex_);
  if (++requested_ <= kLag) return nullptr;
  changed_.wait(lock, [&] { return !steps_.empty() || closed_; });
  if (steps_.empty()) return nullptr;
  MovedPoses moved = std::move(steps_.front());
  steps_.pop_front();
  return moved;
}

void PoseFeedback::close() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace lidar_mapping::pipeline
