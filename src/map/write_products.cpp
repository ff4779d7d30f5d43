// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/write_products.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <unordered_map>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/top_view.hpp"
#include "lidar_mapping/moving_objects/current_clouds.hpp"

#include "files/ept_file.hpp"
#include "files/whole_folder.hpp"
#include "gis/change_files.hpp"
#include "gis/geotiff_files.hpp"
#include "map_formats.hpp"
#include "map_products.hpp"
#include "web/web_page.hpp"

namespace lidar_mapping::map {

namespace {

/// The names in lower case. Throws InputError for an unknown one, and one that cannot be written.
std::vector<std::string> known_formats(const std::vector<std::string>& formats) {
  std::vector<std::string> result;
  for (const std::string& format : formats) {
    result.push_back(lower_case(format));
    if (find_format(result.back()) == nullptr) {
      throw InputError("map format '" + format + "' is not known; use " +
                       joined(product_formats()));
    }
    const std::string obstacle = obstacle_to(result.back());
    if (!obstacle.empty()) throw InputError("map format '" + format + "': " + obstacle);
  }
  return result;
}

/// Stamp and drive of key frames or scans, by index.
std::function<PointOrigin(KeyFrameIndex)> origins_of(const KeyFramePoses& poses,
                                                     const DriveMarks& marks) {
  std::map<Stamp, std::uint32_t> drives;
  std::unordered_map<KeyFrameIndex, const WayPoint*> key_frames;
  for (const WayPoint& point : marks.way) {
    drives[point.stamp] = point.segment;
    key_frames[point.index] = &point;
  }
  const auto drive_of = [&](const KeyFramePose& pose) {
    // Stamps alone do not tell key frames apart: merged drives may have equal ones.
    const auto known = key_frames.find(pose.index);
    if (known != key_frames.end() && known->second->stamp == pose.stamp) {
      return known->second->segment;
    }
    // A scan between two key frames belongs to the drive of the one before.
    const auto next = drives.upper_bound(pose.stamp);
    return next == drives.begin() ? 0U : std::prev(next)->second;
  };
  std::unordered_map<KeyFrameIndex, PointOrigin> origins;
  for (const KeyFramePose& pose : poses.poses) {
    origins[pose.index] = {pose.stamp, static_cast<std::uint16_t>(drive_of(pose))};
  }
  return [origins = std::move(origins)](KeyFrameIndex index) {
    const auto found = origins.find(index);
    return found == origins.end() ? PointOrigin{} : found->second;
  };
}

std::string text_of(const Eigen::Vector3d& p) {
  return formatted("(%g, %g, %g)", p.x(), p.y(), p.z());
}

/// The parts of the clouds that lie in a box of the map.
class CroppedClouds : public CloudSource {
 public:
  CroppedClouds(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::AlignedBox3d& box)
      : clouds_(clouds), box_(box) {
    for (const KeyFramePose& pose : poses.poses) poses_[pose.index] = pose.T_map_base;
  }

  PointCloudPtr cloud(KeyFrameIndex index) override { return cropped(clouds_.cloud(index), index); }
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override {
    std::vector<PointCloudPtr> found = clouds_.clouds(indices, threads);
    for (std::size_t i = 0; i < found.size(); ++i) found[i] = cropped(found[i], indices[i]);
    return found;
  }

 private:
  PointCloudPtr cropped(const PointCloudPtr& cloud, KeyFrameIndex index) const {
    const auto pose = poses_.find(index);
    if (!cloud || pose == poses_.end()) return nullptr;
    auto inside = std::make_shared<PointCloud>();
    for (const Point& point : cloud->points) {
      if (box_.contains(pose->second * point.position().cast<double>())) {
        inside->points.push_back(point);
      }
    }
    return inside;
  }

  CloudSource& clouds_;
  const Eigen::AlignedBox3d box_;
  std::map<KeyFrameIndex, Pose> poses_;
};

}  // namespace

/// Writes the products that the options select. The map is built tile by tile as often as a format
/// needs it.
class ProductWriter {
 public:
  ProductWriter(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                const ProductOptions& options, const std::filesystem::path& directory)
      : poses_(poses), clouds_(clouds), config_(config), options_(options), directory_(directory) {
    if (options.p_base_sensor && !options.keep_moving) {
      moving_objects::MovingObjectsConfig removal;
      removal.threads = config.threads;
      static_clouds_ = std::make_unique<moving_objects::StaticClouds>(
          clouds, poses, *options.p_base_sensor, removal, directory);
      current_clouds_ = std::make_unique<moving_objects::CurrentClouds>(
          clouds, *static_clouds_, poses, *options.p_base_sensor, removal, directory);
      products_.visits = current_clouds_->visits().visits().size();
    }
    if (options.crop) {
      cropped_ = std::make_unique<CroppedClouds>(uncropped(), poses, *options.crop);
    }
  }

  Products write() {
    write_point_files();
    for (const MapFormat& format : map_formats()) {
      if (format.write != nullptr && is_selected(format.name)) (this->*format.write)();
    }
    if (options_.save_removed && static_clouds_) write_removed();
    if (current_clouds_) products_.outdated = current_clouds_->outdated();
    return products_;
  }

  void write_picture() {
    if (!has_picture_) draw();
    add({picture()});
  }

  void write_grid() { add(save_grid(points(), grid_options(), directory_, rays())); }

  void write_tiles() {
    const auto folder = directory_ / "pointcloud_map";
    save_tiles(tiles(), effective_tile_size(config_), folder);
    add({folder});
  }

  void write_ept() {
    if (!has_tiles_of_levels_) make_tiles_of_levels();
    add({ept_folder() / "ept.json"});
  }

  void write_web() {
    if (!has_tiles_of_levels_) make_tiles_of_levels();
    add({ept_folder() / "index.html"});
  }

  void write_geotiff() {
    add(map::write_geotiff(tiles(), options_.datum, options_.pixel, directory_));
  }

  void write_changes() {
    if (!current_clouds_) {
      throw InputError(
          "changes are what the LiDAR has looked through without moving objects: give its position "
          "in base_link, and do not keep moving objects");
    }
    add(map::write_changes(current_clouds_->changes(), current_clouds_->visits().visits(),
                           options_.datum, directory_));
  }

  void write_geojson() { add(map::write_geojson(marks(), options_.datum, directory_)); }

  void write_las() {
    const auto file = directory_ / (options_.name + ".las");
    map::write_las(file, tiles(), options_.datum, max_intensity());
    add({file});
  }

 private:
  bool is_selected(const std::string& format) const { return contains(options_.formats, format); }

  std::filesystem::path ept_folder() const { return directory_ / "ept"; }

  /// The tiles and the page are one folder, which appears as a whole.
  void make_tiles_of_levels() {
    EptOptions ept;
    ept.datum = options_.datum;
    ept.origin = origins_of(poses_, marks());
    ept.octree.threads = config_.threads;
    write_whole_folder(ept_folder(), "ept.json", "Entwine Point Tiles",
                       [&](const std::filesystem::path& folder) {
                         map::write_ept(tiles(), ept, folder);
                         if (!is_selected("web")) return;
                         add_web_page(web_page(), folder);
                       });
    has_tiles_of_levels_ = true;
  }

  WebPage web_page() {
    WebPage page{title(), options_.datum, config_.resolution, marks(), {}, {}};
    if (!current_clouds_) return page;
    page.changes = current_clouds_->changes();
    page.visits = current_clouds_->visits().visits();
    return page;
  }

  /// The name of the session, in whose folder map/ its maps are; else that of the folder.
  std::string title() const {
    const auto folder = folder_path(directory_);
    return (folder.filename() == "map" ? folder.parent_path() : folder).filename().string();
  }

  const DriveMarks& marks() {
    if (!marks_) marks_ = options_.marks ? options_.marks() : marks_of_poses();
    return *marks_;
  }

  DriveMarks marks_of_poses() const {
    DriveMarks marks;
    for (const KeyFramePose& pose : poses_.poses) {
      marks.way.push_back({pose.index, 0, pose.stamp, pose.T_map_base.translation});
    }
    return marks;
  }

  CloudSource& uncropped() {
    if (current_clouds_ && products_.visits > 1 && !options_.keep_outdated) return *current_clouds_;
    if (static_clouds_) return *static_clouds_;
    return clouds_;
  }
  CloudSource& source() {
    if (cropped_) return *cropped_;
    return uncropped();
  }

  TileSource tiles() {
    return [this](const TileSink& sink) {
      products_.points = 0;
      build_tiles(poses_, source(), config_, directory_, [&](const MapTile& tile) {
        products_.points += tile.cloud.size();
        sink(tile);
      });
      if (products_.points > 0) return;
      if (!options_.crop) throw InputError("the map has no points yet; drive first");
      throw InputError("no point of the map lies in the box from " + text_of(options_.crop->min()) +
                       " to " + text_of(options_.crop->max()) +
                       "; map.yaml of the whole map tells its bounds");
    };
  }

  /// The points alone, independent of tiles: built once and stored on the disk.
  const CloudParts& points() {
    if (!points_) points_ = stored_parts(tiles(), directory_);
    return *points_;
  }

  /// Compression takes long and uses one thread: the picture is drawn at the same time.
  void write_point_files() {
    std::vector<std::string> formats;
    for (const std::string& format : point_formats()) {
      if (is_selected(format)) formats.push_back(format);
    }
    if (formats.empty()) return;
    ConcurrentTask concurrent_task;
    if (is_selected("png")) concurrent_task = {[this] { draw(); }, config_.threads};
    add(save_map(options_.utm ? in_utm(points()) : points(), description(), directory_, formats,
                 concurrent_task));
  }

  std::filesystem::path picture() const { return directory_ / "top_view.png"; }

  void draw() {
    write_png(picture(), top_view(points(), options_.pixel));
    has_picture_ = true;
  }

  MapDescription description() const {
    MapDescription description;
    description.frame = options_.frame;
    description.datum = options_.datum;
    description.resolution = config_.resolution;
    description.name = options_.name;
    if (options_.utm) description.utm.emplace(*options_.datum);
    return description;
  }

  /// Points relative to the UTM origin. Grid north differs from true north, and the scale of the
  /// grid is not 1, so each point is converted.
  CloudParts in_utm(const CloudParts& points) const {
    const UtmFrame utm(*options_.datum);
    return stored_parts(
        points,
        [&](const Eigen::Vector3d& p_map) -> Eigen::Vector3d {
          return utm.from_enu(p_map) - utm.origin();
        },
        directory_);
  }

  GridOptions grid_options() const {
    GridOptions options;
    options.cell = grid_cell(config_);
    options.threads = config_.threads;
    return options;
  }

  std::optional<GridRays> rays() {
    if (!options_.p_base_sensor) return std::nullopt;
    return GridRays{poses_, uncropped(), *options_.p_base_sensor};
  }

  float max_intensity() {
    float largest = 0.0F;
    for (const KeyFramePose& pose : poses_.poses) {
      const PointCloudPtr cloud = clouds_.cloud(pose.index);
      if (!cloud) continue;
      for (const Point& point : cloud->points) largest = std::max(largest, point.intensity);
    }
    return largest;
  }

  void write_removed() {
    PointCloud all;
    for (const KeyFramePose& pose : poses_.poses) {
      const PointCloudPtr part = static_clouds_->removed(pose.index);
      if (!part) continue;
      const PointCloud part_in_map = transformed(*part, pose.T_map_base);
      all.points.insert(all.points.end(), part_in_map.points.begin(), part_in_map.points.end());
    }
    products_.removed = all.size();
    const std::filesystem::path file = directory_ / "moving_objects.pcd";
    if (all.empty()) {
      std::filesystem::remove(file);  // it would be that of an older map
      return;
    }
    write_pcd(file, all);
    add({file});
  }

  void add(const Files& files) {
    products_.files.insert(products_.files.end(), files.begin(), files.end());
  }

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

const std::vector<MapFormat>& map_formats() {
  static const std::vector<MapFormat> formats = {
      {"pcd", "", true, &write_pcd, nullptr},
      {"ply", "", true, &write_ply, nullptr},
      {"png", "view from above", false, nullptr, &ProductWriter::write_picture},
      {"las", "", true, nullptr, &ProductWriter::write_las},
      {"tiles", "Autoware", false, nullptr, &ProductWriter::write_tiles},
      {"grid", "map_server", false, nullptr, &ProductWriter::write_grid},
      {"ept", "Entwine Point Tiles", false, nullptr, &ProductWriter::write_ept},
      {"web", "page for a browser", false, nullptr, &ProductWriter::write_web, &web_obstacle},
      {"geotiff", "rasters", false, nullptr, &ProductWriter::write_geotiff, &geotiff_obstacle},
      {"geojson", "trajectory, loops, doubt", false, nullptr, &ProductWriter::write_geojson},
      {"changes", "between visits", false, nullptr, &ProductWriter::write_changes}};
  return formats;
}

const MapFormat* find_format(const std::string& name) {
  for (const MapFormat& format : map_formats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

void check_formats(const std::vector<std::string>& formats) { known_formats(formats); }

std::string obstacle_to(const std::string& format) {
  const MapFormat* known = find_format(format);
  return known == nullptr || known->obstacle == nullptr ? std::string() : known->obstacle();
}

const std::vector<std::string>& product_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const MapFormat& format : map_formats()) all.emplace_back(format.name);
    return all;
  }();
  return names;
}

std::string product_format_help() {
  std::vector<std::string> texts;
  for (const MapFormat& format : map_formats()) {
    texts.emplace_back(format.name);
    if (*format.remark != '\0') texts.back() += " (" + std::string(format.remark) + ")";
  }
  return joined(texts);
}

std::vector<std::string> single_file_formats() {
  std::vector<std::string> names;
  for (const MapFormat& format : map_formats()) {
    if (format.single_file) names.emplace_back(format.name);
  }
  return names;
}

std::vector<std::string> point_formats() {
  std::vector<std::string> names;
  for (const MapFormat& format : map_formats()) {
    if (format.write_points != nullptr) names.emplace_back(format.name);
  }
  return names;
}

std::optional<Eigen::AlignedBox3d> crop_box(const std::vector<double>& corners) {
  if (corners.empty()) return std::nullopt;
  if (corners.size() != 6) {
    throw InputError("a box has six numbers, x0 y0 z0 x1 y1 z1 in m; there are " +
                     std::to_string(corners.size()));
  }
  const Eigen::AlignedBox3d box(Eigen::Vector3d(corners.data()), Eigen::Vector3d(&corners[3]));
  if (!(box.min().array() < box.max().array()).all()) {
    throw InputError("the box from " + text_of(box.min()) + " to " + text_of(box.max()) +
                     " is empty; give the lower corner first, x0 y0 z0 x1 y1 z1");
  }
  return box;
}

Products write_products(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                        const ProductOptions& requested_options,
                        const std::filesystem::path& directory) {
  ProductOptions options = requested_options;
  options.formats = known_formats(requested_options.formats);
  if (contains(options.formats, "grid")) grid_cell(config);
  if (options.utm && !options.datum) {
    throw InputError(
        "the place of the map on Earth is not known, as there was no GNSS; leave UTM out");
  }
  return ProductWriter(poses, clouds, config, options, directory).write();
}

}  // namespace lidar_mapping::map
