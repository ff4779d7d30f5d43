// SPDX-License-Identifier: BSD-3-Clause
#include "product_writer.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <unordered_map>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/top_view.hpp"

#include "files/ept_file.hpp"
#include "files/whole_folder.hpp"
#include "gis/change_files.hpp"
#include "gis/geotiff_files.hpp"
#include "map_formats.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

/// Stamp and drive of key frames or scans, by index.
std::function<PointOrigin(KeyFrameIndex)> origins_of(const KeyFramePoses& poses,
                                                     const DriveMarks& marks) {
  std::map<Stamp, std::uint32_t> drives;
  std::unordered_map<KeyFrameIndex, const PathPoint*> key_frames;
  for (const PathPoint& point : marks.path) {
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

}  // namespace

ProductWriter::ProductWriter(const KeyFramePoses& poses, CloudSource& clouds,
                             const MapConfig& config, const ProductOptions& options,
                             const std::filesystem::path& directory)
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

Products ProductWriter::write() {
  write_point_files();
  for (const MapFormat& format : map_formats()) {
    if (format.write != nullptr && is_selected(format.name)) (this->*format.write)();
  }
  if (options_.save_removed && static_clouds_) write_removed();
  if (leaves_out_outdated()) products_.outdated = current_clouds_->outdated();
  return products_;
}

void ProductWriter::write_picture() {
  if (!has_picture_) draw();
  add({picture()});
}

void ProductWriter::write_grid() {
  add(map::write_grid(points(), grid_options(), directory_, rays()));
}

void ProductWriter::write_tiles() {
  const auto folder = directory_ / "pointcloud_map";
  map::write_tiles(tiles(), effective_tile_size(config_), folder);
  add({folder});
}

void ProductWriter::write_ept() {
  if (!has_tiles_of_levels_) make_tiles_of_levels();
  add({ept_folder() / "ept.json"});
}

void ProductWriter::write_web() {
  if (!has_tiles_of_levels_) make_tiles_of_levels();
  add({ept_folder() / "index.html"});
}

void ProductWriter::write_geotiff() {
  add(map::write_geotiff(tiles(), options_.datum, options_.pixel, directory_));
}

void ProductWriter::write_changes() {
  if (!current_clouds_) {
    throw InputError(
        "changes are what the LiDAR has looked through without moving objects: give its position "
        "in base_link, and do not keep moving objects");
  }
  add(map::write_changes(changes(), current_clouds_->visits().visits(), options_.datum,
                         directory_));
}

std::vector<moving_objects::Change> ProductWriter::changes() {
  std::vector<moving_objects::Change> changes = current_clouds_->changes();
  if (!options_.crop) return changes;
  const auto is_outside = [&](const moving_objects::Change& change) {
    return !options_.crop->intersects(Eigen::AlignedBox3d(change.low, change.high));
  };
  changes.erase(std::remove_if(changes.begin(), changes.end(), is_outside), changes.end());
  return changes;
}

void ProductWriter::write_geojson() {
  add(map::write_geojson(marks(), options_.datum, directory_));
}

void ProductWriter::write_las() {
  const auto file = directory_ / (options_.name + ".las");
  map::write_las(file, tiles(), options_.datum, max_intensity());
  add({file});
}

void ProductWriter::make_tiles_of_levels() {
  EptOptions ept;
  ept.datum = options_.datum;
  ept.origin = origins_of(poses_, marks());
  ept.octree.threads = config_.threads;
  write_whole_folder(ept_folder(), "ept.json", "Entwine Point Tiles",
                     [&](const std::filesystem::path& folder) {
                       map::write_ept(tiles(), ept, folder);
                       if (is_selected("web")) add_web_page(web_page(), folder);
                     });
  has_tiles_of_levels_ = true;
}

bool ProductWriter::is_selected(const std::string& format) const {
  return contains(options_.formats, format);
}

WebPage ProductWriter::web_page() {
  WebPage page{title(), options_.datum, config_.resolution, marks(), {}, {}};
  if (!current_clouds_) return page;
  page.changes = changes();
  page.visits = current_clouds_->visits().visits();
  return page;
}

std::string ProductWriter::title() const {
  const auto folder = folder_path(directory_);
  return (folder.filename() == "map" ? folder.parent_path() : folder).filename().string();
}

const DriveMarks& ProductWriter::marks() {
  if (!marks_) marks_ = options_.marks ? options_.marks() : marks_of_poses();
  return *marks_;
}

DriveMarks ProductWriter::marks_of_poses() const {
  DriveMarks marks;
  for (const KeyFramePose& pose : poses_.poses) {
    marks.path.push_back({pose.index, 0, pose.stamp, pose.T_map_base.translation});
  }
  return marks;
}

bool ProductWriter::leaves_out_outdated() const {
  return current_clouds_ && products_.visits > 1 && !options_.keep_outdated;
}

CloudSource& ProductWriter::uncropped() {
  if (leaves_out_outdated()) return *current_clouds_;
  if (static_clouds_) return *static_clouds_;
  return clouds_;
}

CloudSource& ProductWriter::source() {
  if (cropped_) return *cropped_;
  return uncropped();
}

TileSource ProductWriter::tiles() {
  return [this](const TileSink& sink) {
    products_.points = 0;
    build_tiles(poses_, source(), config_, directory_, [&](const MapTile& tile) {
      products_.points += tile.cloud.size();
      sink(tile);
    });
    if (products_.points > 0) return;
    if (!options_.crop) throw InputError("the map has no points yet; drive first");
    throw InputError("no point of the map lies in " + text_of(*options_.crop) +
                     "; map.yaml of the whole map tells its bounds");
  };
}

const CloudParts& ProductWriter::points() {
  if (!points_) points_ = stored_parts(tiles(), directory_);
  return *points_;
}

void ProductWriter::write_point_files() {
  std::vector<std::string> formats;
  for (const std::string& format : point_formats()) {
    if (is_selected(format)) formats.push_back(format);
  }
  if (formats.empty()) return;
  ConcurrentTask concurrent_task;
  if (is_selected("png")) {
    concurrent_task = {[this] { draw(); }, config_.threads};
  }
  add(map::write_point_files(options_.utm ? in_utm(points()) : points(), description(), directory_,
                             formats, concurrent_task));
}

void ProductWriter::draw() {
  write_png(picture(), top_view(points(), options_.pixel));
  has_picture_ = true;
}

MapDescription ProductWriter::description() const {
  MapDescription description;
  description.frame = options_.frame;
  description.datum = options_.datum;
  description.resolution = config_.resolution;
  description.name = options_.name;
  if (options_.utm) description.utm.emplace(*options_.datum);
  return description;
}

CloudParts ProductWriter::in_utm(const CloudParts& points) const {
  const UtmFrame utm(*options_.datum);
  return stored_parts(
      points,
      [&](const Eigen::Vector3d& p_map) -> Eigen::Vector3d {
        return utm.from_enu(p_map) - utm.origin();
      },
      directory_);
}

GridOptions ProductWriter::grid_options() const {
  GridOptions options;
  options.cell = grid_cell(config_);
  options.threads = config_.threads;
  return options;
}

std::optional<GridRays> ProductWriter::rays() {
  if (!options_.p_base_sensor) return std::nullopt;
  return GridRays{poses_, uncropped(), *options_.p_base_sensor};
}

float ProductWriter::max_intensity() {
  float largest = 0.0F;
  for (const KeyFramePose& pose : poses_.poses) {
    const PointCloudPtr cloud = clouds_.cloud(pose.index);
    if (!cloud) continue;
    for (const Point& point : cloud->points) largest = std::max(largest, point.intensity);
  }
  return largest;
}

void ProductWriter::write_removed() {
  PointCloud all;
  for (const KeyFramePose& pose : poses_.poses) {
    const PointCloudPtr part = static_clouds_->removed(pose.index);
    if (!part) continue;
    const PointCloud part_in_map = transformed(*part, pose.T_map_base);
    for (const Point& point : part_in_map.points) {
      if (!options_.crop || options_.crop->contains(point.position().cast<double>())) {
        all.points.push_back(point);
      }
    }
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

void ProductWriter::add(const Files& files) {
  products_.files.insert(products_.files.end(), files.begin(), files.end());
}

Products write_products(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                        const ProductOptions& requested_options,
                        const std::filesystem::path& directory) {
  ProductOptions options = requested_options;
  options.formats = known_formats(requested_options.formats, config);
  if (options.utm && !options.datum) {
    throw InputError(
        "the place of the map on Earth is not known, as there was no GNSS; leave UTM out");
  }
  return ProductWriter(poses, clouds, config, options, directory).write();
}

}  // namespace lidar_mapping::map
