// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/map/cloud_parts.hpp"

namespace lidar_mapping::map {

class ProductWriter;  // write_products.cpp

/// A format in which a map is written. Whoever has to know the formats asks this table: a new one
/// is a row of it and the function that the row names.
struct MapFormat {
  const char* name;    ///< on command lines, in messages and as the file's extension
  const char* remark;  ///< what it is, if the name does not say it; else empty
  bool one_file;       ///< the map is one file NAME.<name>, which a user may ask for by its path
  /// Of formats that hold the joined points, beside NAME.yaml (save_map()); else null.
  void (*write_points)(const std::filesystem::path& file, const CloudParts& points);
  /// Of all others; else null.
  void (ProductWriter::*write)();
};

/// All formats, in the order in which they are written.
const std::vector<MapFormat>& map_formats();

/// The format of a name, or null.
const MapFormat* find_format(const std::string& name);

}  // namespace lidar_mapping::map
