// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <future>
#include <memory>

#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "drive_chunk.hpp"
#include "threads/pose_feedback.hpp"

namespace lidar_mapping::pipeline {

/// Adds chunks of the drive to the session and the graph, and optimises the graph in the
/// background. A solution that was started at one key frame is applied a fixed number of key frames
/// later, so that the result does not depend on the speed of the processor. One thread calls it.
class GraphUpdater {
 public:
  /// With `in_background` solutions are computed in a thread of their own, else when they are
  /// applied.
  GraphUpdater(session::Session session, const back_end::BackEndConfig& config, bool in_background,
               PoseFeedback& feedback);

  /// Stores a chunk and passes moved poses to the loop search.
  void add(const DriveChunk& chunk);
  /// Optimises the whole graph and writes the files of the session.
  back_end::OptimizationReport finish();

  RecordedBackEnd& back_end() { return recorded_back_end_; }
  /// Processor time of the optimisations so far, s.
  double optimization_seconds() const { return optimization_seconds_; }

 private:
  struct TimedSolution {
    std::shared_ptr<const back_end::OptimizationSolution> solution;
    double seconds = 0.0;
  };

  void record(const DriveChunk& chunk);
  MovedPoses optimize_when_due();
  MovedPoses apply_solution();
  void start_optimization(bool thorough);

  RecordedBackEnd recorded_back_end_;
  std::launch policy_;
  PoseFeedback& feedback_;
  std::size_t key_frames_ = 0;
  std::future<TimedSolution> pending_;
  std::size_t apply_at_ = 0;  ///< Number of key frames at which the current solution is applied.
  double optimization_seconds_ = 0.0;
};

}  // namespace lidar_mapping::pipeline
