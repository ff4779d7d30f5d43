// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/session/session.hpp"

#include "search_chunks.hpp"

namespace lidar_mapping::city {

/// Loops between two drives, and all verdicts of their search. `from` is a key frame of drive a and
/// `to` one of drive b, each by its number within its own drive; stamps are those of drive b.
struct PairLoops {
  std::string a;                      ///< name of the drive in which was searched
  std::string b;                      ///< name of the drive that was searched for
  bool used_gnss = false;             ///< GNSS of both drives placed the candidates
  std::size_t searched = 0;           ///< key frames of drive b that were searched for
  std::vector<Loop> loops;            ///< accepted loops
  std::vector<LoopVerdict> verdicts;  ///< of every candidate that was matched
};

/// Searches the loops of one chunk as loop closing does within a drive, with the graph of both
/// drives behind it. With GNSS in both the candidates are placed by it. If that finds nothing
/// although the drives look alike, the search is repeated without GNSS, because one of the two may
/// be wrong; then matches have to agree over `unanchored_path_length`. The result does not depend
/// on other chunks. `scratch` is a folder for temporary files. Throws FileError.
PairLoops search_chunk(const session::Session& a, const session::Session& b, const Chunk& chunk,
                       const back_end::BackEndConfig& back_end,
                       const loop_closing::LoopClosingConfig& loop_closing,
                       const std::filesystem::path& scratch);

}  // namespace lidar_mapping::city
