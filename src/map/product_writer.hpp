// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/drive_marks.hpp"
#include "lidar_mapping/map/cloud_parts.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/map_tile.hpp"
#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/moving_objects/current_clouds.hpp"

#include "cropped_clouds.hpp"
#include "map_products.hpp"
#include "web/web_page.hpp"

namespace lidar_mapping::map {

/// Writes the products that the options select. The map is built tile by tile as often as a format
/// needs it.
class ProductWriter {
 public:
  /// All references outlive this object; the formats of `options` are known_formats().
  ProductWriter(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                const ProductOptions& options, const std::filesystem::path& directory);

  Products write();

  // Each writes the format of its name; map_formats() refers to them.
  void write_picture();
  void write_grid();
  void write_tiles();
  void write_ept();
  void write_web();
  void write_geotiff();
  void write_changes();
  /// What came and went, in the box of the map if there is one.
  std::vector<moving_objects::Change> changes();
  void write_geojson();
  void write_las();

 private:
  bool is_selected(const std::string& format) const;

  /// Whether the map is that of the last visit to each place.
  bool leaves_out_outdated() const;

  // Sources of what is written.
  CloudSource& uncropped();
  CloudSource& source();
  TileSource tiles();
  /// The points alone, independent of tiles: built once and stored on the disk.
  const CloudParts& points();
  /// Points relative to the UTM origin. Grid north differs from true north, and the scale of the
  /// grid is not 1, so each point is converted.
  CloudParts in_utm(const CloudParts& points) const;
  const DriveMarks& marks();
  DriveMarks marks_of_poses() const;
  std::optional<GridRays> rays();
  float max_intensity();

  // Descriptions that formats take.
  MapDescription description() const;
  GridOptions grid_options() const;
  WebPage web_page();
  /// The name of the session, in whose folder map/ its maps are; else that of the folder.
  std::string title() const;

  // Files that do not belong to a single format.
  /// Compression takes long and uses one thread: the picture is drawn at the same time.
  void write_point_files();
  /// The tiles and the page are one folder, which appears as a whole.
  void make_tiles_of_levels();
  void write_removed();
  void draw();
  std::filesystem::path picture() const { return directory_ / "top_view.png"; }
  std::filesystem::path ept_folder() const { return directory_ / "ept"; }
  void add(const Files& files);

  const KeyFramePoses& poses_;
  CloudSource& clouds_;
  const MapConfig& config_;
  const ProductOptions& options_;
  const std::filesystem::path& directory_;
  std::unique_ptr<moving_objects::StaticClouds> static_clouds_;
  std::unique_ptr<moving_objects::CurrentClouds> current_clouds_;
  std::unique_ptr<CroppedClouds> cropped_;
  std::optional<CloudParts> points_;
  std::optional<DriveMarks> marks_;
  bool has_picture_ = false;
  bool has_tiles_of_levels_ = false;
  Products products_;
};

}  // namespace lidar_mapping::map
