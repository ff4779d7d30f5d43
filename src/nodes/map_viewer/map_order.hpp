// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/ros/messages.hpp"

namespace lidar_mapping::ros_border {

/// What a call of save_map wants, and where.
struct MapOrder {
  map::ProductOptions options;
  std::filesystem::path directory;    ///< empty: that of the session
  std::filesystem::path destination;  ///< the one file that was named; empty: none was

  /// What the answer names.
  const std::filesystem::path& place() const {
    return destination.empty() ? directory : destination;
  }
};

/// Throws InputError for what contradicts itself, and FileError where the file that was named, or
/// one that belongs beside it, exists.
MapOrder map_order(const SaveMap::Request& request);

}  // namespace lidar_mapping::ros_border
