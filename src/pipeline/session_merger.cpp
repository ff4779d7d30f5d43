// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/session_merger.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include "by_stamp.hpp"
#include "datum.hpp"

namespace lidar_mapping::pipeline {

namespace {

using loop_closing::LoopCloser;
using session::Session;

/// Smallest offset (ns) with which no stamp of the part is known yet.
Stamp unique_stamp_offset(const std::vector<KeyFrame>& key_frames, const std::set<Stamp>& known) {
  Stamp stamp_offset = 0;
  const auto is_known = [&](const KeyFrame& key_frame) {
    return known.count(key_frame.stamp + stamp_offset) > 0;
  };
  while (std::any_of(key_frames.begin(), key_frames.end(), is_known)) ++stamp_offset;
  return stamp_offset;
}

/// Calls `add` with the value of this stamp, whose stamp is shifted; does nothing if there is
/// none.
template <typename Value, typename Function>
void add_shifted(const std::map<Stamp, Value>& values, Stamp stamp, Stamp stamp_offset,
                 const Function& add) {
  const auto found = values.find(stamp);
  if (found == values.end()) return;
  Value value = found->second;
  value.stamp += stamp_offset;
  add(value);
}

/// Offsets of a part in the merged session.
struct Offsets {
  KeyFrameIndex index = 0;
  std::uint32_t segment = 0;
  Stamp stamp_offset = 0;
};

Loop with_offsets(Loop loop, const Offsets& offsets) {
  loop.from += offsets.index;
  loop.to += offsets.index;
  loop.stamp += offsets.stamp_offset;
  return loop;
}

LoopVerdict with_offsets(LoopVerdict verdict, const Offsets& offsets) {
  verdict.from += offsets.index;
  verdict.to += offsets.index;
  verdict.stamp += offsets.stamp_offset;
  return verdict;
}

}  // namespace

class SessionMerger::Impl {
 public:
  Impl(Session out, const back_end::BackEndConfig& back_end,
       const loop_closing::LoopClosingConfig& loop_closing)
      : back_end_(std::move(out), back_end),
        closer_(loop_closing, session().clouds(), session().directory()) {}

  void add(const Session& session_part);
  void finish();
  const std::vector<MergedSession>& parts() const { return parts_; }

 private:
  struct Measurements {
    std::map<Stamp, GnssPosition> gnss;
    std::map<Stamp, ImuSample> imu;
    std::map<Stamp, Floor> floors;
    std::multimap<KeyFrameIndex, Loop> loops;  ///< Loops by the index of their newer key frame.
  };

  Session& session() { return back_end_.session(); }
  void copy_settings(const Session& session_part);
  std::vector<GnssPosition> gnss_of(const Session& session_part, MergedSession& merged);
  Measurements measurements_of(const Session& session_part, MergedSession& merged);
  void copy_records(const Session& session_part, const Offsets& offsets);
  void add_key_frame(KeyFrame key_frame, const Session& session_part,
                     const Measurements& measurements, const Offsets& offsets,
                     MergedSession& merged);
  void add_own_loop(const Loop& loop);
  void search(const KeyFrame& key_frame, MergedSession& merged);
  void solve(bool thorough);

  RecordedBackEnd back_end_;
  LoopCloser closer_;
  std::vector<MergedSession> parts_;
  std::set<Stamp> stamps_;
  std::set<std::pair<KeyFrameIndex, KeyFrameIndex>> pairs_;
  Offsets next_;
};

/// Copies the settings of the whole session from the first part.
void SessionMerger::Impl::copy_settings(const Session& session_part) {
  for (const auto& [stage, yaml] : session_part.configurations())
    session().set_configuration(stage, yaml);
  const auto origin = session_part.sensor_origin();
  if (!origin) return;
  session().set_sensor_origin(*origin);
  closer_.set_sensor_origin(*origin);
}

/// Positions of a part in the East-North-Up frame of the merged session.
std::vector<GnssPosition> SessionMerger::Impl::gnss_of(const Session& session_part,
                                                       MergedSession& merged) {
  std::vector<GnssPosition> positions = session_part.gnss();
  if (positions.empty()) return positions;
  const auto datum = session_part.datum();
  if (!datum && parts_.empty()) return positions;
  if (!datum) {
    merged.notices.push_back(session_part.directory().string() +
                             " does not know the datum of its GNSS positions; they are left out");
    return {};
  }
  if (!session().datum()) {
    if (!session().gnss().empty()) {
      merged.notices.push_back("the sessions before " + session_part.directory().string() +
                               " do not know the datum of their GNSS positions, so those of this "
                               "one are left out; name the sessions with a datum first");
      return {};
    }
    session().set_datum(*datum);
  }
  const Pose T_new_old = enu_between(*session().datum(), *datum);
  for (GnssPosition& position : positions) position = transformed_position(position, T_new_old);
  return positions;
}

SessionMerger::Impl::Measurements SessionMerger::Impl::measurements_of(const Session& session_part,
                                                                       MergedSession& merged) {
  Measurements result;
  result.gnss = by_stamp(gnss_of(session_part, merged));
  result.imu = by_stamp(session_part.imu());
  result.floors = by_stamp(session_part.floors());
  for (const Loop& loop : session_part.loops())
    result.loops.emplace(std::max(loop.from, loop.to), loop);
  return result;
}

/// Copies records that the graph does not need but the report does.
void SessionMerger::Impl::copy_records(const Session& session_part, const Offsets& offsets) {
  Session::Batch batch(session());
  for (session::ScanRecord scan : session_part.scans()) {
    scan.stamp += offsets.stamp_offset;
    session().add_scan(scan);
  }
  for (const auto& [stamp, pose] : session_part.odometry()) {
    session().add_odometry(stamp + offsets.stamp_offset, pose);
  }
  for (const LoopVerdict& verdict : session_part.verdicts()) {
    session().add_verdict(with_offsets(verdict, offsets));
  }
  batch.commit();
}

void SessionMerger::Impl::add(const Session& session_part) {
  if (parts_.empty()) copy_settings(session_part);
  MergedSession merged;
  const std::vector<KeyFrame> key_frames = session_part.key_frames();
  const Measurements measurements = measurements_of(session_part, merged);
  Offsets offsets = next_;
  offsets.stamp_offset = unique_stamp_offset(key_frames, stamps_);
  merged.first = key_frames.empty() ? offsets.index : offsets.index + key_frames.front().index;
  merged.key_frames = key_frames.size();
  merged.stamp_offset = offsets.stamp_offset;
  copy_records(session_part, offsets);
  for (const KeyFrame& key_frame : key_frames) {
    add_key_frame(key_frame, session_part, measurements, offsets, merged);
  }
  solve(true);
  parts_.push_back(merged);
}

void SessionMerger::Impl::add_key_frame(KeyFrame key_frame, const Session& session_part,
                                        const Measurements& measurements, const Offsets& offsets,
                                        MergedSession& merged) {
  const KeyFrameIndex own_index = key_frame.index;
  const Stamp own_stamp = key_frame.stamp;
  key_frame.cloud = session_part.clouds().cloud(own_index);
  key_frame.index += offsets.index;
  key_frame.segment += offsets.segment;
  key_frame.stamp += offsets.stamp_offset;
  back_end_.add_key_frame(key_frame);
  stamps_.insert(key_frame.stamp);
  next_.index = key_frame.index + 1;
  next_.segment = key_frame.segment + 1;
  add_shifted(measurements.gnss, own_stamp, offsets.stamp_offset,
              [&](const GnssPosition& position) {
                back_end_.add_gnss(position);
                closer_.add_gnss(position);
              });
  add_shifted(measurements.imu, own_stamp, offsets.stamp_offset,
              [&](const ImuSample& sample) { back_end_.add_imu(sample); });
  add_shifted(measurements.floors, own_stamp, offsets.stamp_offset,
              [&](const Floor& floor) { back_end_.add_floor(floor); });
  // Loop closing has already searched the first drive.
  if (parts_.empty()) {
    closer_.restore(key_frame);
  } else {
    search(key_frame, merged);
  }
  const auto [begin, end] = measurements.loops.equal_range(own_index);
  for (auto loop = begin; loop != end; ++loop) add_own_loop(with_offsets(loop->second, offsets));
  if (!parts_.empty() && back_end_.optimization_due()) solve(false);
}

void SessionMerger::Impl::add_own_loop(const Loop& loop) {
  if (!back_end_.add_loop(loop)) return;
  if (loop.decision != LoopDecision::kAuto) {
    session().set_loop_decision(loop.from, loop.to, loop.decision);
  }
  if (loop.decision != LoopDecision::kRefuse) closer_.add_loop(loop);
  pairs_.emplace(loop.from, loop.to);
}

void SessionMerger::Impl::search(const KeyFrame& key_frame, MergedSession& merged) {
  const loop_closing::LoopClosingResult found = closer_.process(key_frame);
  for (const LoopVerdict& verdict : found.verdicts) session().add_verdict(verdict);
  for (const Loop& loop : found.loops) {
    if (!pairs_.emplace(loop.from, loop.to).second) continue;
    if (back_end_.add_loop(loop)) ++merged.new_loops;
  }
}

void SessionMerger::Impl::solve(bool thorough) {
  const auto solution = back_end::solve(*back_end_.problem(thorough));
  closer_.update_poses(back_end_.apply(*solution, 0.0).poses);
}

void SessionMerger::Impl::finish() {
  solve(true);
  back_end_.write_files();
  std::map<KeyFrameIndex, int> part_of;
  const KeyFramePoses poses = back_end_.poses();
  const std::vector<int> all = back_end_.parts();
  for (std::size_t i = 0; i < all.size(); ++i) part_of[poses.poses[i].index] = all[i];
  std::set<int> first;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    std::set<int> own;
    const bool last = p + 1 == parts_.size();
    const auto end = last ? part_of.end() : part_of.lower_bound(parts_[p + 1].first);
    for (auto it = part_of.lower_bound(parts_[p].first); it != end; ++it) own.insert(it->second);
    if (p == 0) first = own;
    parts_[p].is_connected = std::any_of(
        own.begin(), own.end(), [&](int graph_part) { return first.count(graph_part) > 0; });
  }
}

SessionMerger::SessionMerger(Session out, const back_end::BackEndConfig& back_end,
                             const loop_closing::LoopClosingConfig& loop_closing)
    : impl_(std::make_unique<Impl>(std::move(out), back_end, loop_closing)) {}
SessionMerger::~SessionMerger() = default;

void SessionMerger::add(const Session& session_part) { impl_->add(session_part); }
void SessionMerger::finish() { impl_->finish(); }
const std::vector<MergedSession>& SessionMerger::parts() const { return impl_->parts(); }

}  // namespace lidar_mapping::pipeline
