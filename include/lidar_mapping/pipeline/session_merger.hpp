// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/loop_closing/loop_closer.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"

namespace lidar_mapping::pipeline {

/// Result for one of the sessions that were merged.
struct MergedSession {
  KeyFrameIndex first = 0;     ///< Index of its first key frame in the merged session.
  std::size_t key_frames = 0;  ///< Number of its key frames.
  std::size_t new_loops = 0;   ///< Loops that were found to earlier sessions or within this one.
  Stamp stamp_offset = 0;      ///< Offset that was added to its stamps so that they are unique, ns.
  bool is_connected = false;   ///< Loops or GNSS connect it to the first session.
  std::vector<std::string> notices;  ///< What could not be copied, a line each.
};

/// Merges sessions into a new one, one after the other: key frames are renumbered consecutively,
/// each drive begins a new segment, GNSS positions are transformed to the datum of the first
/// session that has one, and loop closing searches between the drives as it does within a drive
/// (doc/session.md).
class SessionMerger {
 public:
  /// `out` is a new session. It gets the sensor origin and the stored configuration of the first
  /// session that is added.
  SessionMerger(session::Session out, const back_end::BackEndConfig& back_end,
                const loop_closing::LoopClosingConfig& loop_closing);

  /// Adds all of a session and optimises the graph. Clouds are hard links to those of the part
  /// where the disk allows that. `ties` are loops to earlier sessions that are known already: from
  /// a key frame of the merged session to one of the part, whose index and stamp are those in the
  /// part. Throws FileError if the disk fails.
  void add(const session::Session& part, const std::vector<Loop>& ties = {});
  /// Optimises the whole graph and writes the files of the session. `is_connected` of the parts is
  /// valid from here on.
  void finish();

  /// Results for the sessions in the order in which they were added.
  const std::vector<MergedSession>& parts() const { return parts_; }

 private:
  session::Session& session() { return back_end_.session(); }
  std::vector<GnssPosition> gnss_of(const session::Session& part, MergedSession& merged);
  void add_key_frame(const KeyFrame& key_frame, const SessionPart& part, MergedSession& merged);
  void add_ties(const std::vector<Loop>& ties, const PartOffsets& offsets, SessionPart& part);
  void use_own_loop(const Loop& loop);
  void search(const KeyFrame& key_frame, MergedSession& merged);
  void solve(bool thorough);

  RecordedBackEnd back_end_;
  loop_closing::LoopCloser closer_;
  std::vector<MergedSession> parts_;
  std::set<Stamp> stamps_;
  /// Key frames with a loop, of the parts or new, which the search does not add again.
  std::set<std::pair<KeyFrameIndex, KeyFrameIndex>> pairs_;
  PartOffsets next_;
};

}  // namespace lidar_mapping::pipeline
