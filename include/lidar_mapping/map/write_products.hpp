// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/drive_marks.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/map/map_files.hpp"

namespace lidar_mapping::map {

/// Names that ProductOptions::formats may hold, in upper or lower case.
const std::vector<std::string>& product_formats();
/// Throws InputError for a format that is not known, for one that cannot be written here because an
/// optional package is missing, and for one that these parameters do not fit, as a grid with cells
/// smaller than the voxels; the error names the remedy.
void check_formats(const std::vector<std::string>& formats, const MapConfig& config);
/// Why a known format cannot be written here, with the remedy; empty if it can.
std::string obstacle_to(const std::string& format);
/// The same names in one line with explanations: "pcd, ply, png (view from above), ...".
std::string product_format_help();
/// Formats that put the map into one file, whose extension is the name of the format.
std::vector<std::string> single_file_formats();

/// Formats that hold nothing but points, such as "pcd". Their files are named by the format, too.
std::vector<std::string> point_formats();

/// The box of the corners x0 y0 z0 x1 y1 z1 in m; none if `corners` is empty. Throws InputError for
/// any other number of values, and for an empty box.
std::optional<Eigen::AlignedBox3d> crop_box(const std::vector<double>& corners);

/// Which files are made of a map, and how.
struct ProductOptions {
  std::vector<std::string> formats = {"pcd", "ply", "png"};  ///< Names of product_formats().
  /// Edge of a pixel of the view from above and of rasters, m.
  double pixel = 0.2;
  std::string frame = "map";           ///< Name of the frame of the points (frame_id).
  std::optional<GeodeticDatum> datum;  ///< Origin of the East-North-Up frame; none without GNSS.
  /// Position of the LiDAR in base_link, m. If it is given, points of moving objects are left out,
  /// and cells of the grid are free where rays passed.
  std::optional<Eigen::Vector3d> p_base_sensor;
  /// Box of the map frame, m; points outside of it are left out.
  std::optional<Eigen::AlignedBox3d> crop;
  /// Writes point_formats() in UTM relative to the datum. (las is always in UTM, the other formats
  /// in the map frame.)
  bool utm = false;
  std::string name = "map";  ///< Name of single files, without extension.
  bool keep_moving = false;  ///< Keeps the points of moving objects in the map.
  /// Keeps the points of what later visits have looked through. Without the position of the LiDAR,
  /// and with `keep_moving`, they are kept in any case.
  bool keep_outdated = false;
  /// Gives the path, the loops and the doubtful sections for formats that show them; empty: these
  /// show the path alone. Called when a format needs it.
  std::function<DriveMarks()> marks;
  bool save_removed = false;  ///< Writes the points of moving objects to moving_objects.pcd.
};

/// What write_products() has made.
struct Products {
  Files files;               ///< Files and folders that were written.
  std::size_t points = 0;    ///< Points of the map; 0 if no product needed them.
  std::size_t removed = 0;   ///< Points of moving objects; counted only if they are saved.
  std::size_t visits = 1;    ///< Visits (moving_objects::Visits) whose changes were looked for.
  std::size_t outdated = 0;  ///< Points of key frames that were left out as outdated.
};

/// Builds the map of these poses tile by tile and writes it into the folder (map_files.hpp,
/// map_products.hpp, top_view.hpp). Throws FileError, and InputError for a format that
/// check_formats() refuses, a map (or box) without points, or UTM without a datum.
Products write_products(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                        const ProductOptions& options, const std::filesystem::path& directory);

}  // namespace lidar_mapping::map
