// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/session/loop_files.hpp"

namespace lidar_mapping::pipeline {

/// Returns the loops on which the edits of a person change something, each with its decision; of
/// several edits of a pair the last one holds. Added loops are matched as loop closing does it.
/// Nothing is written. Throws InputError with the line of the edit
/// if there is no such loop or if a pair does not match.
std::vector<Loop> edited_loops(const session::Session& session,
                               const std::vector<session::LoopEdit>& edits,
                               const loop_closing::LoopClosingConfig& config);

/// Returns `loops` with each loop of `edited` in the place of the one between the same key frames,
/// or appended if there is none.
std::vector<Loop> replace_loops(std::vector<Loop> loops, const std::vector<Loop>& edited);

/// Stores the decisions in the session, and the loops if they are new.
void store_decisions(session::Session& session, const std::vector<Loop>& edited);

}  // namespace lidar_mapping::pipeline
