// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/map/map_files.hpp"

namespace lidar_mapping::map {

/// What ProductOptions::formats may hold, in capitals or not.
const std::vector<std::string>& product_formats();
/// The same in one line with what they are: "pcd, ply, png (view from above), ...".
std::string product_format_help();
/// Those of which a map is one file, with the format's name as its extension.
std::vector<std::string> one_file_formats();

/// The box of x0 y0 z0 x1 y1 z1, m; none of no numbers. Throws InputError for another count, and
/// where it is empty.
std::optional<Eigen::AlignedBox3d> crop_box(const std::vector<double>& corners);

/// What is made of a map, and how.
struct ProductOptions {
  std::vector<std::string> formats = {"pcd", "ply", "png"};
  double pixel = 0.2;  ///< of the view from above, m
  std::string frame = "map";
  std::optional<GeodeticDatum> datum;
  /// The LiDAR in base_link, m. If it is known points of moving objects are left out, and the grid
  /// is free where rays passed.
  std::optional<Eigen::Vector3d> p_base_sensor;
  /// Only what lies in this box of the map frame (m) is put into the map.
  std::optional<Eigen::AlignedBox3d> crop;
  /// pcd and ply in UTM, relative to the datum (las always is in UTM, the others in the map frame).
  bool utm = false;
  std::string name = "map";   ///< of formats that are one file, without extension
  bool keep_moving = false;   ///< leaves points of moving objects in
  bool save_removed = false;  ///< writes the points left out to moving_objects.pcd
};

struct Products {
  Files files;
  std::size_t points = 0;   ///< of the map
  std::size_t removed = 0;  ///< counted if they are saved
};

/// Builds the map of the poses tile by tile and writes it into the folder (map_files.hpp,
/// map_products.hpp, top_view.hpp). Throws FileError, and InputError for a format that is not
/// known, a map (or box) without points, UTM without a datum, or cells of the grid that are smaller
/// than the voxels.
Products write_products(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                        const ProductOptions& options, const std::filesystem::path& directory);

}  // namespace lidar_mapping::map
