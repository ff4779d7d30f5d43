#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::tools {

/// What is made of a session: the command line's side of map::ProductOptions.
struct MapOutput {
  std::string folder;       ///< for the files; empty: map/ of the session
  double resolution = 0.0;  ///< m; 0: as in the drive
  double tile_size = 0.0;   ///< m; 0: as in the drive
  int threads = 0;          ///< 0: all cores
  bool keep_moving = false;
  std::vector<double> sensor_origin;  ///< empty: as the session has it
  map::ProductOptions products;
};

/// Builds the map from the session's newest poses and writes it; prints what it makes of it.
/// Returns the files. Throws FileError, and InputError for a session without points.
map::Files write_map(const session::Session& session, const MapOutput& output);

}  // namespace lidar_mapping::tools
