// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "map_output.hpp"

namespace lidar_mapping::tools {

/// Which scans of a recording go into a map, and how dense.
struct ScanMapInput {
  std::vector<std::string> recording;  ///< as map_bag takes it
  int every = 1;                       ///< each so many-th scan
  std::optional<double> resolution;    ///< m, of the scans' voxels; none: as the key frames have it
};

/// Builds the map of a session from the scans of its recording instead of from its key frames
/// alone. Returns the files. Throws FileError, and InputError for another recording.
map::Files write_scan_map(const session::Session& session, const MapOutput& output,
                          const ScanMapInput& input);

}  // namespace lidar_mapping::tools
