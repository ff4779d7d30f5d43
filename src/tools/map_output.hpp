#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::tools {

/// What is made of a session, and how.
struct ProductOptions {
  std::string output;       ///< folder for the files; empty: map/ of the session
  double resolution = 0.0;  ///< m; 0: as in the drive
  double tile_size = 0.0;   ///< m; 0: as in the drive
  double pixel = 0.2;       ///< of the view from above, m
  int threads = 0;          ///< 0: all cores
  bool keep_moving = false;
  bool save_removed = false;
  std::vector<double> sensor_origin;  ///< empty: as the session has it
  std::vector<std::string> formats = {"pcd", "ply", "png"};
};

/// What ProductOptions::formats may hold.
const std::vector<std::string>& product_formats();

/// Builds the map from the session's newest poses and writes it; prints what it makes of it.
/// Returns the files. Throws FileError, and InputError for a session without points.
map::Files write_products(const session::Session& session, const ProductOptions& options);

}  // namespace lidar_mapping::tools
