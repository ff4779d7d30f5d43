// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/pipeline/pipeline_config.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

namespace lidar_mapping::pipeline {

/// Repeating the last section of a session did not lead to the pose at which the session ends: see
/// PipelineConfig::replay_whole.
class ResumeFailure : public Error {
  using Error::Error;
};

/// Progress of the processing.
struct Progress {
  Stamp newest = 0;            ///< Stamp of the newest scan that the front end has processed, ns.
  std::size_t scans = 0;       ///< Scans that the front end has processed.
  std::size_t key_frames = 0;  ///< Key frames, including those of a session that is resumed.
  std::size_t loops = 0;       ///< Loops, including those of a session that is resumed.
};

/// Result of a run, with the processor time that it took.
struct PipelineReport {
  back_end::OptimizationReport optimization;  ///< The last optimisation, that of the whole drive.
  preprocessing::PreprocessingCounters counters;  ///< What preprocessing accepted and dropped.
  Progress progress;                              ///< Numbers of scans, key frames and loops.
  std::size_t scans_unreadable = 0;  ///< Scans that were left out because their data are damaged.
  /// Scans that were left out after time went back, because they are older than the newest one.
  std::size_t scans_before_newest = 0;
  /// Name and processor time (s) of each stage.
  std::vector<std::pair<std::string, double>> stage_seconds;
};

/// All stages in one process: turns recorded sensor data into a session (doc/pipeline.md). Each
/// stage has a thread and a bounded queue. Results that travel against the direction of the stream,
/// such as poses for the loop search, are applied a fixed number of key frames after they were
/// requested, so that the session has the same bytes for any number of threads. One thread calls
/// it.
class Pipeline {
 public:
  /// Resumes `session` if it has content: its recording has to be added again from resume_time()
  /// on. `T_base` is called from another thread.
  Pipeline(const PipelineConfig& config, session::Session session,
           preprocessing::ExtrinsicLookup T_base);
  ~Pipeline();

  /// Time before which no data need to be added when a session is resumed; none if all data are
  /// needed.
  std::optional<Stamp> resume_time() const;
  /// Adds a datum; waits while the queues are full. Throws FileError if the session cannot be
  /// written; its contents stay valid. If a session is resumed it throws ResumeFailure, and
  /// InputError for another recording; the session is then unchanged.
  void add(Input input);
  /// Processes all data in the queues, optimises the whole graph and updates the files of the
  /// session.
  PipelineReport finish();

  /// Current progress; callable while other threads work.
  Progress progress() const;
  /// Messages about events and problems since the last call.
  std::vector<std::string> take_messages();
  /// The session; valid after finish().
  const session::Session& session() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::pipeline
