// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::pipeline {

/// All poses of the drive; null where none has moved.
using MovedPoses = std::shared_ptr<const KeyFramePoses>;

/// Poses that go back from the graph to the loop search: step n of the search sees what step
/// n - kLag of the graph has left, however fast both are.
class PoseFeedback {
 public:
  static constexpr std::size_t kLag = 4;

  /// The graph has done its next step.
  void put(MovedPoses moved);
  /// For the search's next step: waits for the graph. Null also where the graph has failed.
  MovedPoses take();
  /// The graph has failed; nobody waits for it any longer.
  void close();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<MovedPoses> steps_;
  std::size_t taken_ = 0;
  bool closed_ = false;
};

}  // namespace lidar_mapping::pipeline
