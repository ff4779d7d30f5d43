#pragma once

#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include "drive_piece.hpp"
#include "pose_feedback.hpp"

namespace lidar_mapping::pipeline {

/// Adds to a piece of the drive the loops that its key frame closes. One thread calls it.
class LoopSearch {
 public:
  LoopSearch(const loop_closing::LoopClosingConfig& config, CloudSource& clouds,
             PoseFeedback& feedback)
      : closer_(config, clouds), feedback_(feedback) {}

  void take(DrivePiece& piece);
  /// Takes in what a session that is gone on with holds.
  void restore(const session::Session& session);

 private:
  loop_closing::LoopCloser closer_;
  PoseFeedback& feedback_;
};

}  // namespace lidar_mapping::pipeline
