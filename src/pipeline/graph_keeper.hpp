// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <future>
#include <memory>

#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "drive_piece.hpp"
#include "pose_feedback.hpp"

namespace lidar_mapping::pipeline {

/// Puts pieces of the drive into the session and the graph, and has the graph solved beside. A
/// solution that was begun at one key frame is taken a fixed number of key frames later. One thread
/// calls it.
class GraphKeeper {
 public:
  /// With `beside` solutions are computed in a thread of their own.
  GraphKeeper(session::Session session, const back_end::BackEndConfig& config, bool beside,
              PoseFeedback& feedback);

  void take(const DrivePiece& piece);
  /// Solves the whole graph and writes the session's files.
  back_end::OptimizationReport finish();

  RecordedBackEnd& run() { return run_; }
  /// Processor time of solutions so far, s.
  double solving_seconds() const { return solving_seconds_; }

 private:
  struct Solved {
    std::shared_ptr<const back_end::OptimizationSolution> solution;
    double seconds = 0.0;
  };

  void record(const DrivePiece& piece);
  MovedPoses solve_when_due();
  MovedPoses take_solution();
  void start_solving(bool thorough);

  RecordedBackEnd run_;
  std::launch policy_;
  PoseFeedback& feedback_;
  std::size_t key_frames_ = 0;
  std::future<Solved> solving_;
  std::size_t take_at_ = 0;  ///< key frames at which the solution that is computed is taken
  std::size_t kept_at_ = 0;  ///< key frames when poses were last written to the session
  double solving_seconds_ = 0.0;
};

}  // namespace lidar_mapping::pipeline
