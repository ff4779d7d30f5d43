// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::tools {

/// Options for the map of a session, as given on the command line.
struct MapOutput {
  std::string folder;                ///< for the files; empty: map/ of the session
  std::optional<double> resolution;  ///< m; none: as in the drive
  std::optional<double> tile_size;   ///< m; none: as in the drive
  std::optional<double> grid_cell;   ///< m; none: as in the drive
  std::string poses;                 ///< a trajectory with stamps; empty: the session's poses
  int threads = 0;                   ///< 0: all cores
  std::string as_of;  ///< date by ISO 8601, up to which key frames are used; empty: all
  std::vector<double> sensor_origin;  ///< empty: as the session has it
  map::ProductOptions products;
};

/// Throws ConfigError or InputError if a number is not allowed. It is called before the drive is
/// mapped, so that a mistake is reported at once.
void check_numbers(const MapOutput& output);

/// Poses of the session's key frames: optimised ones, and odometry after the last of them.
KeyFramePoses key_frame_poses(const session::Session& session);
/// The same, or where the trajectory that `output` names has them, between two of its poses at most
/// half a second apart; without those after the date of `output`. Throws FileError, and InputError
/// if none is left.
KeyFramePoses key_frame_poses(const session::Session& session, const MapOutput& output);

/// The folder for the files.
std::filesystem::path map_folder(const session::Session& session, const MapOutput& output);

/// Builds the map from the session's newest poses and writes it; prints messages. Returns the
/// files. Throws FileError, and InputError for a session without points.
map::Files write_map(const session::Session& session, const MapOutput& output);
/// The same with other clouds than those of the key frames; `name` is their name in the plural.
map::Files write_map(const session::Session& session, const MapOutput& output,
                     const KeyFramePoses& poses, CloudSource& clouds, const std::string& name);

}  // namespace lidar_mapping::tools
