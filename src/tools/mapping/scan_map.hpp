// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mapping/map_output.hpp"

namespace lidar_mapping::tools {

/// Selection of the scans of a recording for a map, and their density.
struct ScanMapInput {
  std::vector<std::string> recording;  ///< paths as for map_bag
  int every = 1;                       ///< uses every n-th scan
  std::optional<double> resolution;    ///< m, of the scans' voxels; none: as the key frames have it
};

/// Builds the map of a session from the scans of its recording instead of from its key frames
/// alone. Returns the files. Throws FileError, and InputError for another recording.
map::Files write_scan_map(const session::Session& session, const MapOutput& output,
                          const ScanMapInput& input);

}  // namespace lidar_mapping::tools
