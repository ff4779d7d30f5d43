// SPDX-License-Identifier: BSD-3-Clause
#include "graph_updater.hpp"

#include <algorithm>

#include "lidar_mapping/common/thread_time.hpp"

namespace lidar_mapping::pipeline {

namespace {

/// Number of key frames from the start of an optimisation to its use. It grows with the graph, so
/// that the stage does not have to wait.
std::size_t solution_delay(std::size_t key_frames) { return 4 + key_frames / 250; }

/// Size of the cache of clouds in bytes. It shrinks as graph, solutions and loop search need more
/// memory for each key frame. A quarter remains, because the cache holds the clouds between two
/// stages, too. Loop closing does not depend on it, even in a drive of hours, because it keeps
/// downsampled clouds of its own.
std::size_t cloud_cache_bytes(std::size_t key_frames) {
  constexpr std::size_t kPerKeyFrame = 15'000;  // bytes; measured, see doc/results/pipeline.md
  constexpr std::size_t kFullCache = session::CloudStore::kDefaultCacheBytes;
  return kFullCache - std::min(kFullCache / 4 * 3, kPerKeyFrame * key_frames);
}

}  // namespace

GraphUpdater::GraphUpdater(session::Session session, const back_end::BackEndConfig& config,
                           bool in_background, PoseFeedback& feedback)
    : recorded_back_end_(std::move(session), config),
      policy_(in_background ? std::launch::async : std::launch::deferred),
      feedback_(feedback),
      key_frames_(recorded_back_end_.session().key_frame_count()) {}

void GraphUpdater::add(const DriveChunk& chunk) try {
  record(chunk);
  if (!chunk.key_frame) return;
  recorded_back_end_.session().clouds().set_cache_bytes(cloud_cache_bytes(++key_frames_));
  feedback_.add_step(optimize_when_due());
} catch (...) {
  feedback_.close();
  throw;
}

/// Stores a chunk as one batch: after a kill the session has all of it or nothing.
void GraphUpdater::record(const DriveChunk& chunk) {
  session::Session& session = recorded_back_end_.session();
  session::Session::Batch batch(session);
  if (chunk.datum) recorded_back_end_.set_datum(*chunk.datum);
  if (chunk.p_base_lidar) session.set_sensor_origin(*chunk.p_base_lidar);
  for (const ScanEntry& scan : chunk.scans) {
    session.add_scan(scan.record);
    session.add_odometry(scan.record.stamp, scan.T_odom_base);
    if (scan.gnss) recorded_back_end_.add_gnss(*scan.gnss);
    if (scan.imu) recorded_back_end_.add_imu(*scan.imu);
  }
  if (chunk.floor) recorded_back_end_.add_floor(*chunk.floor);
  if (chunk.key_frame) recorded_back_end_.add_key_frame(*chunk.key_frame);
  for (const Loop& loop : chunk.loops) recorded_back_end_.add_loop(loop);
  for (const LoopVerdict& verdict : chunk.verdicts) recorded_back_end_.add_verdict(verdict);
  batch.commit();
}

MovedPoses GraphUpdater::optimize_when_due() {
  MovedPoses moved;
  if (pending_.valid() && key_frames_ >= apply_at_) moved = apply_solution();
  if (!pending_.valid() && recorded_back_end_.optimization_due()) start_optimization(false);
  return moved;
}

void GraphUpdater::start_optimization(bool thorough) {
  apply_at_ = key_frames_ + solution_delay(key_frames_);
  pending_ = std::async(policy_, [problem = recorded_back_end_.problem(thorough)] {
    const ThreadTime time;
    TimedSolution result;
    result.solution = back_end::solve(*problem);
    result.seconds = time.seconds();
    return result;
  });
}

MovedPoses GraphUpdater::apply_solution() {
  const TimedSolution result = pending_.get();
  optimization_seconds_ += result.seconds;
  return std::make_shared<const KeyFramePoses>(
      recorded_back_end_.apply(*result.solution, 0.0, PoseStorage::kWhenGrown).poses);
}

back_end::OptimizationReport GraphUpdater::finish() {
  if (pending_.valid()) apply_solution();
  back_end::OptimizationReport report;
  if (key_frames_ == 0) {
    report.message = "there are no key frames; nothing to optimise";
    return report;
  }
  start_optimization(true);
  const TimedSolution result = pending_.get();
  optimization_seconds_ += result.seconds;
  recorded_back_end_.apply(*result.solution, 0.0);
  recorded_back_end_.write_files();
  report = back_end::report_of(*result.solution);
  report.seconds = result.seconds;
  return report;
}

}  // namespace lidar_mapping::pipeline
