// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::ros_border {

/// Key frames of a run that its session lacks, because it could not be written.
class UnstoredKeyFrames {
 public:
  /// Begins a run, unless it is the one that key frames were added of.
  void begin_run(const std::string& run_id) {
    if (run_id == run_id_) return;
    run_id_ = run_id;
    indices_.clear();
  }
  void add(const std::string& run_id, KeyFrameIndex index, const std::string& reason) {
    begin_run(run_id);
    indices_.insert(index);
    reason_ = reason;
  }
  /// It came again, and was stored.
  void remove(KeyFrameIndex index) { indices_.erase(index); }

  bool empty() const { return indices_.empty(); }
  /// For people: how many, and the reason of the last one.
  std::string text() const {
    return std::to_string(indices_.size()) + " key frames could not be stored (" + reason_ + ")";
  }

 private:
  std::string run_id_;
  std::set<KeyFrameIndex> indices_;
  std::string reason_;
};

}  // namespace lidar_mapping::ros_border
