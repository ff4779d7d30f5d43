// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"

#include "drive_consistency.hpp"
#include "pair_search.hpp"

namespace lidar_mapping::city {

/// The name of a drive: that of the folder of its session.
std::string drive_name(const std::filesystem::path& session);

/// What became of a drive.
enum class DriveState {
  kJoined,      ///< it is in the map of the city, or the part of it that is connected
  kDetached,    ///< it contradicts the others and is left out
  kUnconnected  ///< nothing joins it to the others, so its place is not known
};
/// "joined", "detached", "unconnected".
const char* to_string(DriveState state);

/// A drive in the graph of the city.
struct JoinedDrive {
  std::string name;               ///< drive_name()
  std::filesystem::path session;  ///< that folder
  DriveState state = DriveState::kJoined;
  std::vector<std::string> notices;  ///< why it or its GNSS is left out, a sentence each
  bool has_gnss = false;             ///< it has positions that could be used
  bool uses_gnss = false;            ///< they are used
  pipeline::PartOffsets offsets;     ///< of its key frames in the city
  std::vector<KeyFrame> key_frames;  ///< those in the city, with its indices and stamps
  std::size_t left_out = 0;          ///< number of the key frames that are not in the city
  LoopUsage loops;                   ///< loops to other drives
};

/// The drives and the loops between them, judged.
struct JoinedCity {
  std::vector<JoinedDrive> drives;     ///< in the order of the input
  std::vector<Loop> loops;             ///< between drives that are in the city, with its indices
  std::optional<GeodeticDatum> datum;  ///< origin of the city's map; empty without GNSS
};

/// Joins drives to one pose graph and judges each of them: GNSS that contradicts the loops to other
/// drives is left out, a drive whose loops the graph mostly refuses is detached, and what nothing
/// connects with the largest part is left out. Drives with the same `datum` lie in its
/// East-North-Up frame; the first one of a drive is taken if it is empty. Throws FileError, and
/// InputError if loops name an unknown drive or key frame.
JoinedCity join_drives(const std::vector<std::filesystem::path>& sessions,
                       const std::vector<PairLoops>& loops,
                       const std::optional<GeodeticDatum>& datum,
                       const back_end::BackEndConfig& config);

}  // namespace lidar_mapping::city
