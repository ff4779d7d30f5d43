// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/loop_closing/loop_closer.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "drive_chunk.hpp"
#include "threads/pose_feedback.hpp"

namespace lidar_mapping::pipeline {

/// Adds to a chunk of the drive the loops that its key frame closes. One thread calls it.
class LoopSearch {
 public:
  LoopSearch(const loop_closing::LoopClosingConfig& config, session::Session& session,
             PoseFeedback& feedback)
      : closer_(config, session.clouds(), session.directory()), feedback_(feedback) {}

  void process(DriveChunk& chunk);
  /// Restores the state of the search from the session of a drive that is resumed. Key frames with
  /// matches that still wait for others are searched again.
  void restore(const RecordedBackEnd& back_end);

 private:
  void search_again(const RecordedBackEnd& back_end, const KeyFrame& key_frame);

  loop_closing::LoopCloser closer_;
  PoseFeedback& feedback_;
  loop_closing::LoopClosingResult found_again_;  ///< Goes with the next chunk.
};

}  // namespace lidar_mapping::pipeline
