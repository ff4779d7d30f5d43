// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

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
  ~SessionMerger();

  /// Adds all of a session and optimises the graph. Clouds are hard links to those of the part
  /// where the disk allows that. `ties` are loops to earlier sessions that are known already: from
  /// a key frame of the merged session to one of the part, whose index and stamp are those in the
  /// part. Throws FileError if the disk fails.
  void add(const session::Session& part, const std::vector<Loop>& ties = {});
  /// Optimises the whole graph and writes the files of the session. `is_connected` of the parts is
  /// valid from here on.
  void finish();

  /// Results for the sessions in the order in which they were added.
  const std::vector<MergedSession>& parts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::pipeline
