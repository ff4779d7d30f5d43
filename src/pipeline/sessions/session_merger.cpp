// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/session_merger.hpp"

#include <algorithm>
#include <map>

#include "lidar_mapping/session/imported_map.hpp"

namespace lidar_mapping::pipeline {

namespace {

using session::Session;

/// The cloud of a key frame of `part`, whose file `merged` takes over; null if there is none.
PointCloudPtr linked_cloud(const Session& part, KeyFrameIndex own_index, Session& merged,
                           KeyFrameIndex index) {
  if (!part.clouds().contains(own_index)) return nullptr;
  merged.clouds().link(index, part.clouds().file(own_index));
  return merged.clouds().cloud(index);
}

/// The older key frame and the newer one.
std::pair<KeyFrameIndex, KeyFrameIndex> pair_of(const Loop& loop) {
  return std::minmax(loop.from, loop.to);
}

}  // namespace

SessionMerger::SessionMerger(Session out, const back_end::BackEndConfig& back_end,
                             const loop_closing::LoopClosingConfig& loop_closing)
    : back_end_(std::move(out), back_end),
      closer_(loop_closing, session().clouds(), session().directory()) {}

/// Positions of a part in the East-North-Up frame of the merged session.
std::vector<GnssPosition> SessionMerger::gnss_of(const Session& session_part,
                                                 MergedSession& merged) {
  const std::vector<GnssPosition> positions = session_part.gnss();
  const auto datum = session_part.datum();
  // An imported map lies in its datum's frame without any position.
  if (datum && parts_.empty() && session::is_imported_map(session_part)) {
    session().set_datum(*datum);
  }
  if (positions.empty()) return positions;
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
  return gnss_in_frame_of(session().datum(), session_part);
}

void SessionMerger::add(const Session& session_part, const std::vector<Loop>& ties) {
  if (parts_.empty()) {
    copy_settings(session_part, session());
    if (const auto origin = session().sensor_origin()) closer_.set_sensor_origin(*origin);
  }
  MergedSession merged;
  const std::vector<GnssPosition> gnss = gnss_of(session_part, merged);
  PartOffsets offsets = next_;
  offsets.stamp = unique_stamp_offset(stamps_of(session_part), stamps_);
  stamps_.merge(stamps_of(session_part, offsets.stamp));
  SessionPart part = read_part(session_part, offsets, gnss);
  add_ties(ties, offsets, part);
  // Before the search: a loop that it finds again is the part's own, with a person's decision.
  for (const auto& [newer, loop] : part.loops) pairs_.insert(pair_of(loop));
  merged.first = part.key_frames.empty() ? offsets.index : part.key_frames.front().index;
  merged.key_frames = part.key_frames.size();
  merged.stamp_offset = offsets.stamp;
  copy_records(session_part, offsets, session());
  for (KeyFrame key_frame : part.key_frames) {
    key_frame.cloud =
        linked_cloud(session_part, key_frame.index - offsets.index, session(), key_frame.index);
    add_key_frame(key_frame, part, merged);
  }
  // Also a part without a key frame has a number of its drive of its own.
  next_.segment = std::max(next_.segment, offsets.segment + 1);
  solve(true);
  parts_.push_back(merged);
}

void SessionMerger::add_key_frame(const KeyFrame& key_frame, const SessionPart& part,
                                  MergedSession& merged) {
  pipeline::add_key_frame(part, key_frame, back_end_, closer_);
  next_.index = key_frame.index + 1;
  next_.segment = key_frame.segment + 1;
  // Loop closing has already searched the first drive.
  if (parts_.empty()) {
    closer_.restore(key_frame);
  } else {
    search(key_frame, merged);
  }
  add_loops(part, key_frame.index, back_end_, [&](const Loop& loop) { use_own_loop(loop); });
  if (!parts_.empty() && back_end_.optimization_due()) solve(false);
}

/// They come with the loops of the part.
void SessionMerger::add_ties(const std::vector<Loop>& ties, const PartOffsets& offsets,
                             SessionPart& part) {
  for (Loop tie : ties) {
    tie.to += offsets.index;
    tie.stamp += offsets.stamp;
    part.loops.emplace(tie.to, tie);
  }
}

void SessionMerger::use_own_loop(const Loop& loop) {
  if (loop.decision != LoopDecision::kAuto) {
    session().set_loop_decision(loop.from, loop.to, loop.decision);
  }
  if (loop.decision != LoopDecision::kRefuse) closer_.add_loop(loop);
}

void SessionMerger::search(const KeyFrame& key_frame, MergedSession& merged) {
  const loop_closing::LoopClosingResult found = closer_.process(key_frame);
  for (const LoopVerdict& verdict : found.verdicts) back_end_.add_verdict(verdict);
  for (const Loop& loop : found.loops) {
    if (!pairs_.insert(pair_of(loop)).second) continue;
    if (back_end_.add_loop(loop)) ++merged.new_loops;
  }
}

void SessionMerger::solve(bool thorough) {
  const auto solution = back_end::solve(*back_end_.problem(thorough));
  closer_.update_poses(back_end_.apply(*solution, 0.0).poses);
}

void SessionMerger::finish() {
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

}  // namespace lidar_mapping::pipeline
