// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

/// All loops with the newest verdict on each: from, to, stamp, pose, fitness, overlap, source,
/// decision, verdict, reason. Throws FileError.
void write_loops_csv(const Session& session, const std::filesystem::path& path);

/// Every candidate that was ever matched, taken or not: from, to, stamp, source, what became of it
/// in the end, the figures of its matching, and the reason. Throws FileError.
void write_candidates_csv(const Session& session, const std::filesystem::path& path);

/// All loops as a list that a person edits (doc/session.md): a line per loop with what was decided
/// about it and, as a comment, what the graph thinks. Throws FileError.
void write_loop_list(const Session& session, const std::filesystem::path& path);

/// A line of such a list: a decision about a loop that is there, or a pair to be matched.
struct LoopEdit {
  KeyFrameIndex from = 0;  ///< always the smaller one
  KeyFrameIndex to = 0;
  bool add = false;
  LoopDecision decision = LoopDecision::kAuto;
  std::optional<Pose> guess;  ///< T_from_to, of an added one
  std::string where;          ///< file and line, for messages
};

/// Reads such a list: "auto|accept|refuse FROM TO" and "add FROM TO [X Y Z [ROLL PITCH YAW]]" (m,
/// degrees); # begins a comment. Throws FileError, and InputError naming the line.
std::vector<LoopEdit> read_loop_list(const std::filesystem::path& path);

}  // namespace lidar_mapping::session
