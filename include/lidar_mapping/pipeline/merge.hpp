// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

namespace lidar_mapping::pipeline {

/// What became of one of the sessions that were joined.
struct MergedPart {
  KeyFrameIndex first = 0;  ///< of its key frames in the joined session
  std::size_t key_frames = 0;
  std::size_t new_loops = 0;  ///< found to what was there before, or within it
  Stamp shift = 0;            ///< ns that its stamps were moved by, so that none occurs twice
  bool joined = false;        ///< loops or GNSS tie it to the first session
  std::vector<std::string> notices;  ///< what could not be taken over, a line each
};

/// Adds one session after the other to a new one: key frames are numbered on, each drive begins a
/// segment of its own, GNSS is turned to the datum of the first session that has one, and loop
/// closing searches between the drives as it does in a drive that goes on (doc/session.md).
class Merge {
 public:
  /// `out` is a new session. Its sensor origin and stored configuration become those of the first
  /// part.
  Merge(session::Session out, const back_end::BackEndConfig& back_end,
        const loop_closing::LoopClosingConfig& loop_closing);
  ~Merge();

  /// Throws FileError where the disk says no.
  void add(const session::Session& part);
  /// Solves everything together and writes the session's files. `joined` of the parts is valid
  /// from here on.
  void finish();

  const std::vector<MergedPart>& parts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::pipeline
