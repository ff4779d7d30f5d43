// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/session/loop_files.hpp"

namespace lidar_mapping::pipeline {

/// The loops that a person's edits concern, each with the decision; added ones as loop closing
/// matched them. Nothing is written. Throws InputError naming the line where there is no such loop
/// or where a pair does not match.
std::vector<Loop> decided_loops(const session::Session& session,
                                const std::vector<session::LoopEdit>& edits,
                                const loop_closing::LoopClosingConfig& config);

/// `loops` with those of `decided` in their place, or behind them.
std::vector<Loop> replaced(std::vector<Loop> loops, const std::vector<Loop>& decided);

/// Keeps decisions, and the loops where they are new, in the session.
void keep_decisions(session::Session& session, const std::vector<Loop>& decided);

}  // namespace lidar_mapping::pipeline
