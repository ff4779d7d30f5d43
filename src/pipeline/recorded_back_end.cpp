// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include <algorithm>
#include <chrono>
#include <set>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/datum.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/session/loop_files.hpp"
#include "lidar_mapping/session/trajectory_files.hpp"

namespace lidar_mapping::pipeline {

namespace {

session::RevisionRecord record_of(const back_end::OptimizationReport& report,
                                  std::uint32_t revision, double seconds) {
  session::RevisionRecord record;
  record.revision = revision;
  record.key_frames = report.key_frames;
  static_cast<UsageCounts&>(record) = report;
  record.cost_before = report.cost_before;
  record.cost_after = report.cost_after;
  record.seconds = seconds;
  return record;
}

std::string reason_of(const Loop& loop, bool used, bool uses_loops) {
  if (loop.decision == LoopDecision::kRefuse) return "a person refused it";
  if (!uses_loops) return "loops are not used (use_loop_close)";
  if (loop.decision == LoopDecision::kAccept) return "a person accepted it";
  return used ? "the graph agrees with it"
              : "the graph leaves it out: it contradicts the other constraints";
}

bool say_the_same(const LoopVerdict& a, const LoopVerdict& b) {
  return a.verdict == b.verdict && a.reason == b.reason;
}

/// Whether to store that many poses: each time the drive has grown by a twentieth, so that the
/// time for it stays in proportion to the drive. A session that was interrupted is optimised again
/// anyway.
bool are_due(std::size_t poses, std::size_t stored) { return poses >= stored + 20 + stored / 20; }

}  // namespace

RecordedBackEnd::RecordedBackEnd(session::Session session, const back_end::BackEndConfig& config)
    : session_(std::move(session)), back_end_(config), uses_loops_(config.use_loop_close) {
  if (session_.key_frame_count() > 0) {
    resume();
  } else {
    opening_report_ = back_end::report_of(*back_end::solve(*back_end_.problem(true)));
  }
}

void RecordedBackEnd::resume() {
  replay(session_, back_end_);
  stored_poses_ = session_.poses().poses.size();
  const auto revisions = session_.revisions();
  if (!revisions.empty()) first_revision_ = revisions.back().revision;
  const std::vector<LoopVerdict> verdicts = session_.verdicts();
  for (const LoopVerdict& verdict : verdicts) note_said(verdict);
  const auto stored = newest_verdicts(verdicts);
  for (const auto& [loop, used] : back_end_.loops()) {
    loop_poses_[{loop.from, loop.to}] = loop.T_from_to;
    const auto verdict = stored.find({loop.from, loop.to});
    if (verdict != stored.end()) last_verdicts_.insert(*verdict);
  }
  solve_at_opening();
}

/// Settings or decisions may have changed since the last solution was stored, and data may have
/// come: this one is stored like any other.
void RecordedBackEnd::solve_at_opening() {
  const auto begin = std::chrono::steady_clock::now();
  const auto solution = back_end::solve(*back_end_.problem(true));
  opening_report_ = back_end::report_of(*solution);
  opening_report_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  apply(*solution, opening_report_.seconds, PoseStorage::kWhenGrown);
}

void RecordedBackEnd::add_key_frame(const KeyFrame& key_frame) {
  session_.add_key_frame(key_frame);
  KeyFrame without_cloud = key_frame;
  without_cloud.cloud = nullptr;
  back_end_.add_key_frame(without_cloud);
}

bool RecordedBackEnd::add_loop(const Loop& loop) {
  if (!back_end_.fits(loop)) return false;
  session_.add_loop(loop);
  back_end_.add_loop(loop);
  loop_poses_[{loop.from, loop.to}] = loop.T_from_to;
  return true;
}

bool RecordedBackEnd::has_loop(const Loop& loop) const {
  // m and rad. Chosen far below any error: poses that were sent in messages are equal in every bit.
  constexpr double kSamePose = 1e-9;
  const auto found = loop_poses_.find({loop.from, loop.to});
  return found != loop_poses_.end() &&
         (loop.source != LoopSource::kManual ||
          difference(found->second, loop.T_from_to).norm() < kSamePose);
}

void RecordedBackEnd::add_gnss(const GnssPosition& position) {
  const GnssPosition in_session = transformed_position(position, T_session_gnss_);
  session_.add_gnss(in_session);
  back_end_.add_gnss(in_session);
}

/// Whether the same was said of the two key frames before.
bool RecordedBackEnd::was_said(const LoopVerdict& verdict) const {
  return said_.count({verdict.from, verdict.to, verdict.verdict, verdict.reason}) > 0;
}

void RecordedBackEnd::note_said(const LoopVerdict& verdict) {
  said_.emplace(verdict.from, verdict.to, verdict.verdict, verdict.reason);
}

void RecordedBackEnd::add_verdict(const LoopVerdict& verdict) {
  if (was_said(verdict)) return;
  session_.add_verdict(verdict);
  note_said(verdict);
  const auto last = last_verdicts_.find({verdict.from, verdict.to});
  if (last != last_verdicts_.end()) last->second = verdict;
}

void RecordedBackEnd::set_datum(const GeodeticDatum& datum) {
  const auto found = session_.datum();
  if (!found) session_.set_datum(datum);
  T_session_gnss_ = enu_between(found.value_or(datum), datum);
}

void RecordedBackEnd::add_imu(const ImuSample& sample_base) {
  session_.add_imu(sample_base);
  back_end_.add_imu(sample_base);
}

void RecordedBackEnd::add_floor(const Floor& floor) {
  session_.add_floor(floor);
  back_end_.add_floor(floor);
}

/// The graph has moved even if the session cannot be written: whoever follows it has to know.
AppliedSolution RecordedBackEnd::apply(const back_end::OptimizationSolution& solution,
                                       double seconds, PoseStorage storage) {
  back_end_.apply(solution);
  AppliedSolution applied;
  applied.poses = poses();
  applied.verdicts = changed_verdicts();
  unstored_ = record_of(back_end::report_of(solution), applied.poses.revision, seconds);
  unstored_verdicts_.insert(unstored_verdicts_.end(), applied.verdicts.begin(),
                            applied.verdicts.end());
  try {
    store_solution(applied.poses, storage);
  } catch (const FileError& error) {
    applied.storing_failure = error.what();
  }
  return applied;
}

/// Present verdicts that are not the last ones of the graph. A corrected loop has two in it.
std::vector<LoopVerdict> RecordedBackEnd::changed_verdicts() {
  std::vector<LoopVerdict> changed;
  for (const auto& [pair, verdict] : newest_verdicts(verdicts())) {
    LoopVerdict& last = last_verdicts_[pair];
    if (say_the_same(verdict, last)) continue;
    last = verdict;
    changed.push_back(verdict);
  }
  return changed;
}

void RecordedBackEnd::store_solution(const KeyFramePoses& poses, PoseStorage storage) {
  store_verdicts();
  const bool is_due = storage == PoseStorage::kAlways || are_due(poses.poses.size(), stored_poses_);
  // Who makes a map meanwhile of the newest poses asks the session in which frame they lie.
  if (is_due || back_end_.in_enu() != session_.poses_in_enu().value_or(false)) {
    store_poses(poses);
  } else {
    session_.set_revision(*unstored_);
  }
  if (is_due) stored_poses_ = poses.poses.size();
}

void RecordedBackEnd::store_verdicts() {
  for (; !unstored_verdicts_.empty(); unstored_verdicts_.pop_front()) {
    session_.add_verdict(unstored_verdicts_.front());
  }
}

void RecordedBackEnd::store_poses(const KeyFramePoses& poses) {
  session_.set_poses(poses, *unstored_, back_end_.in_enu());
  unstored_.reset();
}

KeyFrameIndex RecordedBackEnd::searched_key_frames() const {
  KeyFrameIndex searched = 0;
  std::set<std::pair<KeyFrameIndex, KeyFrameIndex>> open;  // by the newer key frame
  for (const LoopVerdict& verdict : session_.verdicts()) {
    searched = std::max(searched, verdict.to + 1);
    if (is_waiting(verdict)) {
      open.emplace(verdict.to, verdict.from);
    } else {
      open.erase({verdict.to, verdict.from});
    }
  }
  return open.empty() ? searched : open.begin()->first;
}

KeyFramePoses RecordedBackEnd::poses() const {
  KeyFramePoses poses = back_end_.poses();
  poses.revision += first_revision_;
  return poses;
}

std::vector<LoopVerdict> RecordedBackEnd::verdicts() const {
  std::vector<LoopVerdict> verdicts;
  for (const auto& [loop, used] : back_end_.loops()) {
    verdicts.push_back(verdict_on(loop, used ? Verdict::kAccepted : Verdict::kRefused,
                                  reason_of(loop, used, uses_loops_)));
  }
  return verdicts;
}

std::vector<std::string> RecordedBackEnd::write_files() {
  store_verdicts();
  if (unstored_) store_poses(poses());
  return warnings(write_results(session_, back_end_, poses(), session_.directory()));
}

void replay(const session::Session& session, const std::vector<Loop>& loops,
            back_end::BackEnd& back_end) {
  std::set<Stamp> stamps;
  for (const KeyFrame& key_frame : session.key_frames()) {
    back_end.add_key_frame(key_frame);
    stamps.insert(key_frame.stamp);
  }
  const auto is_at_key_frame = [&](const auto& value) { return stamps.count(value.stamp) > 0; };
  for (const GnssPosition& position : session.gnss()) {
    if (is_at_key_frame(position)) back_end.add_gnss(position);
  }
  for (const ImuSample& sample : session.imu()) {
    if (is_at_key_frame(sample)) back_end.add_imu(sample);
  }
  for (const Floor& floor : session.floors()) {
    if (is_at_key_frame(floor)) back_end.add_floor(floor);
  }
  for (const Loop& loop : loops) back_end.add_loop(loop);
}

void replay(const session::Session& session, back_end::BackEnd& back_end) {
  replay(session, session.loops(), back_end);
}

DriveDoubt write_results(const session::Session& session, const back_end::BackEnd& back_end,
                         const KeyFramePoses& poses, const std::filesystem::path& directory) {
  session::write_trajectories(session, poses, back_end.positions(), directory / "trajectory");
  session::write_loops_csv(session, directory / "loops.csv");
  session::write_candidates_csv(session, directory / "candidates.csv");
  session::write_loop_list(session, directory / "loops.txt");
  DriveDoubt doubt = drive_doubt(session, back_end, poses);
  write_doubt(doubt, directory / "doubt.csv");
  pose_graph::write_g2o(back_end.graph(), (directory / "graph.g2o").string());
  return doubt;
}

}  // namespace lidar_mapping::pipeline
