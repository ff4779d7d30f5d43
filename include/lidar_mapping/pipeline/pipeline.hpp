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

/// The last stretch of a session, driven once more, did not lead to where the session ends: see
/// PipelineConfig::replay_whole.
class ResumeFailure : public Error {
  using Error::Error;
};

/// How far it has come.
struct Progress {
  Stamp newest = 0;  ///< of the scans that the front end has taken
  std::size_t scans = 0;
  std::size_t key_frames = 0;  ///< with those of a session that is gone on with
  std::size_t loops = 0;       ///< likewise
};

/// What was done, and what it took.
struct PipelineReport {
  back_end::OptimizationReport optimization;  ///< the last, of the whole drive
  preprocessing::PreprocessingCounters counters;
  Progress progress;
  std::size_t scans_unreadable = 0;
  /// Processor time of each stage, s.
  std::vector<std::pair<std::string, double>> stage_seconds;
};

/// The stages put together: what sensors sent becomes a session (doc/pipeline.md). Each stage has a
/// thread and a bounded queue. Results that travel against the stream, as poses to the loop search,
/// are taken at a fixed number of key frames after they were asked for: the session has the same
/// bytes for any number of threads. One thread calls it.
class Pipeline {
 public:
  /// A session that has content is gone on with: its recording is to be added again, from
  /// resumes_from() on. `T_base` is called from another thread.
  Pipeline(const PipelineConfig& config, session::Session session,
           preprocessing::ExtrinsicLookup T_base);
  ~Pipeline();

  /// Earlier data need not be added; nothing if all are needed.
  std::optional<Stamp> resumes_from() const;
  /// Waits while the stages are behind. Throws FileError when the session cannot be written; what
  /// is in it then stays whole. With a session that is gone on with throws ResumeFailure, and
  /// InputError for another recording; the session is as it was then.
  void add(Input input);
  /// Works off what waits, solves the whole graph and brings the session's files up to date.
  PipelineReport finish();

  Progress progress() const;
  /// Sentences about what was found or went wrong since the last call.
  std::vector<std::string> take_notices();
  /// After finish().
  const session::Session& session() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::pipeline
