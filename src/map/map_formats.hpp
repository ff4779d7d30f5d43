// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/map/cloud_parts.hpp"

namespace lidar_mapping::map {

struct MapConfig;     // map_config.hpp
class ProductWriter;  // product_writer.hpp

/// A format in which a map is written. All code that has to know the formats uses this table: a new
/// format is a row of it and the function that the row names.
struct MapFormat {
  using PointsWriter = void (*)(const std::filesystem::path& file, const CloudParts& points);
  using ProductWriterMember = void (ProductWriter::*)();

  /// Name on command lines, in messages and as extension of the file.
  const char* name = "";
  /// Explanation if the name does not say what it is; else empty.
  const char* remark = "";
  /// The map is a single file NAME.<name>, which a user may select by its path.
  bool single_file = false;
  /// Writer of formats that hold the points of the whole map, beside NAME.yaml
  /// (write_point_files()); null for others.
  PointsWriter write_points = nullptr;
  /// Writer of all other formats; null for those with `write_points`.
  ProductWriterMember write = nullptr;
  /// Why the format cannot be written on this machine, with the remedy; empty text if it can. Null:
  /// it always can.
  std::string (*obstacle)() = nullptr;
  /// Throws InputError for parameters with which the format cannot be written. Null: all will do.
  void (*check)(const MapConfig& config) = nullptr;
};

/// All formats, in the order in which they are written.
const std::vector<MapFormat>& map_formats();

/// The format of this name; null if there is none.
const MapFormat* find_format(const std::string& name);

/// The names in lower case. Throws InputError for an unknown one, and one that cannot be written on
/// this machine or with these parameters.
std::vector<std::string> known_formats(const std::vector<std::string>& formats,
                                       const MapConfig& config);

}  // namespace lidar_mapping::map
