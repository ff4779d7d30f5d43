// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

/// Writes a table of all loops with the newest verdict on each: from, to, stamp, pose, fitness,
/// overlap, source, decision, verdict, reason. Throws FileError.
void write_loops_csv(const Session& session, const std::filesystem::path& path);

/// Writes a table of all candidates that were matched, accepted or not: from, to, stamp, source,
/// final verdict, figures of the match, and the reason. Throws FileError.
void write_candidates_csv(const Session& session, const std::filesystem::path& path);

/// Writes all loops as a list that a person can edit (doc/session.md): one line per loop with the
/// decision on it and, as a comment, the verdict of the graph. Throws FileError.
void write_loop_list(const Session& session, const std::filesystem::path& path);

/// A line of such a list: a decision on an existing loop, or a new pair to be matched.
struct LoopEdit {
  KeyFrameIndex from = 0;                       ///< the smaller index
  KeyFrameIndex to = 0;                         ///< the larger index
  bool add = false;                             ///< the pair is to be matched
  LoopDecision decision = LoopDecision::kAuto;  ///< decision of the person; kAccept for a new pair
  std::optional<Pose> guess;                    ///< guess of T_from_to for a new pair
  std::string where;                            ///< file and line, for messages
};

/// Reads such a list. A line is "auto|accept|refuse FROM TO" or "add FROM TO [X Y Z [ROLL PITCH
/// YAW]]" (m, degrees); # begins a comment. Throws FileError if the file cannot be read, and
/// InputError with the number of the line if a line cannot be understood.
std::vector<LoopEdit> read_loop_list(const std::filesystem::path& path);

}  // namespace lidar_mapping::session
