// SPDX-License-Identifier: BSD-3-Clause
#include "graph_keeper.hpp"

#include <algorithm>

#include "lidar_mapping/pipeline/thread_time.hpp"

namespace lidar_mapping::pipeline {

namespace {

/// A larger graph takes longer: nobody should have to wait for it.
std::size_t solving_key_frames(std::size_t key_frames) { return 4 + key_frames / 250; }

/// Poses are written each time that the drive has grown by a twentieth: a session that was broken
/// off is solved again anyway.
bool worth_keeping(std::size_t key_frames, std::size_t kept_at) {
  return key_frames >= kept_at + 20 + kept_at / 20;
}

/// Clouds make room for what graph, solutions and the loop search take for each key frame. A
/// quarter of the cache stays: it holds the clouds that are between two stages, too. Loop closing
/// keeps thinned clouds of its own, so a drive of hours misses nothing.
std::size_t cache_beside(std::size_t key_frames) {
  constexpr std::size_t kPerKeyFrame = 15'000;
  constexpr std::size_t kWhole = session::CloudStore::kDefaultCacheBytes;
  return kWhole - std::min(kWhole / 4 * 3, kPerKeyFrame * key_frames);
}

}  // namespace

GraphKeeper::GraphKeeper(session::Session session, const back_end::BackEndConfig& config,
                         bool beside, PoseFeedback& feedback)
    : run_(std::move(session), config),
      policy_(beside ? std::launch::async : std::launch::deferred),
      feedback_(feedback),
      key_frames_(run_.session().key_frame_count()),
      kept_at_(key_frames_) {}

void GraphKeeper::take(const DrivePiece& piece) try {
  record(piece);
  if (!piece.key_frame) return;
  run_.session().clouds().set_cache_bytes(cache_beside(++key_frames_));
  feedback_.put(solve_when_due());
} catch (...) {
  feedback_.close();
  throw;
}

/// One event of the session: all of it is there after a kill, or nothing.
void GraphKeeper::record(const DrivePiece& piece) {
  session::Session& session = run_.session();
  session::Session::Batch batch(session);
  if (piece.datum) run_.set_datum(*piece.datum);
  if (piece.p_base_lidar) session.set_sensor_origin(*piece.p_base_lidar);
  for (const ScanEntry& scan : piece.scans) {
    session.add_scan(scan.record);
    session.add_odometry(scan.record.stamp, scan.T_odom_base);
    if (scan.gnss) run_.add_gnss(*scan.gnss);
    if (scan.imu) run_.add_imu(*scan.imu);
  }
  if (piece.floor) run_.add_floor(*piece.floor);
  if (piece.key_frame) run_.add_key_frame(*piece.key_frame);
  for (const Loop& loop : piece.loops) run_.add_loop(loop);
  for (const LoopVerdict& verdict : piece.verdicts) session.add_verdict(verdict);
  batch.commit();
}

MovedPoses GraphKeeper::solve_when_due() {
  MovedPoses moved;
  if (solving_.valid() && key_frames_ >= take_at_) moved = take_solution();
  if (!solving_.valid() && run_.optimization_due()) start_solving(false);
  return moved;
}

void GraphKeeper::start_solving(bool thorough) {
  take_at_ = key_frames_ + solving_key_frames(key_frames_);
  solving_ = std::async(policy_, [problem = run_.problem(thorough)] {
    const ThreadTime time;
    Solved solved;
    solved.solution = back_end::solve(*problem);
    solved.seconds = time.seconds();
    return solved;
  });
}

MovedPoses GraphKeeper::take_solution() {
  const Solved solved = solving_.get();
  solving_seconds_ += solved.seconds;
  const bool keep = worth_keeping(key_frames_, kept_at_);
  if (keep) kept_at_ = key_frames_;
  return std::make_shared<const KeyFramePoses>(run_.apply(*solved.solution, 0.0, keep).poses);
}

back_end::OptimizationReport GraphKeeper::finish() {
  if (solving_.valid()) take_solution();
  back_end::OptimizationReport report;
  if (key_frames_ == 0) {
    report.message = "there are no key frames; nothing to optimise";
    return report;
  }
  start_solving(true);
  const Solved solved = solving_.get();
  solving_seconds_ += solved.seconds;
  run_.apply(*solved.solution, 0.0);
  run_.write_files();
  report = back_end::report_of(*solved.solution);
  report.seconds = solved.seconds;
  return report;
}

}  // namespace lidar_mapping::pipeline
