#include "lidar_mapping/map/write_products.hpp"

#include <algorithm>
#include <memory>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/map_products.hpp"
#include "lidar_mapping/map/moving_objects.hpp"
#include "lidar_mapping/map/top_view.hpp"

namespace lidar_mapping::map {

namespace {

bool is_among(const std::string& format, const std::vector<std::string>& formats) {
  return std::find(formats.begin(), formats.end(), format) != formats.end();
}

void check(const std::vector<std::string>& formats) {
  for (const std::string& format : formats) {
    if (is_among(format, product_formats())) continue;
    std::string known;
    for (const std::string& name : product_formats()) known += (known.empty() ? "" : ", ") + name;
    throw InputError("map format '" + format + "' is not known; use " + known);
  }
}

class Writer {
 public:
  Writer(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
         const ProductOptions& options, const std::filesystem::path& directory)
      : poses_(poses), clouds_(clouds), config_(config), options_(options), directory_(directory) {
    if (!options.p_base_sensor) return;
    MovingObjectsConfig removal;
    removal.threads = config.threads;
    fixed_ =
        std::make_unique<StaticClouds>(clouds, poses, *options.p_base_sensor, removal, directory);
  }

  Products write() {
    write_joined();
    write_tiled();
    if (options_.save_removed && fixed_) write_removed();
    return products_;
  }

 private:
  bool wants(const std::string& format) const { return is_among(format, options_.formats); }

  CloudSource& source() {
    if (fixed_) return *fixed_;
    return clouds_;
  }

  TileSource tiles() {
    return [this](const TileSink& sink) {
      products_.points = 0;
      build_tiles(poses_, source(), config_, directory_, [&](const MapTile& tile) {
        products_.points += tile.cloud.size();
        sink(tile);
      });
    };
  }

  /// What is made of the points alone, wherever the tiles' borders are.
  void write_joined() {
    std::vector<std::string> formats;
    for (const char* format : {"pcd", "ply"}) {
      if (wants(format)) formats.emplace_back(format);
    }
    if (formats.empty() && !wants("png") && !wants("grid")) return;
    const CloudParts points = stored_parts(tiles(), directory_);
    Files picture;
    const auto draw = [&] {
      if (!wants("png")) return;
      picture = {directory_ / "top_view.png"};
      write_png(picture.front(), top_view(points, options_.pixel));
    };
    if (formats.empty()) {
      draw();
    } else {
      add(save_map(points, {options_.frame, options_.datum, config_.resolution}, directory_,
                   formats, {draw, config_.threads}));
    }
    add(picture);
    if (wants("grid")) add(save_grid(points, {}, directory_));
  }

  void write_tiled() {
    if (wants("tiles")) {
      const auto folder = directory_ / "pointcloud_map";
      save_tiles(tiles(), true_tile_size(config_), folder);
      add({folder});
    }
    if (wants("las")) {
      write_las(directory_ / "map.las", tiles(), options_.datum, max_intensity());
      add({directory_ / "map.las"});
    }
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
      const PointCloudPtr part = fixed_->removed(pose.index);
      if (!part) continue;
      const PointCloud placed = transformed(*part, pose.T_map_base);
      all.points.insert(all.points.end(), placed.points.begin(), placed.points.end());
    }
    products_.removed = all.size();
    if (all.empty()) return;
    write_pcd(directory_ / "moving_objects.pcd", all);
    add({directory_ / "moving_objects.pcd"});
  }

  void add(const Files& files) {
    products_.files.insert(products_.files.end(), files.begin(), files.end());
  }

  const KeyFramePoses& poses_;
  CloudSource& clouds_;
  const MapConfig& config_;
  const ProductOptions& options_;
  const std::filesystem::path& directory_;
  std::unique_ptr<StaticClouds> fixed_;
  Products products_;
};

}  // namespace

const std::vector<std::string>& product_formats() {
  static const std::vector<std::string> formats = {"pcd", "ply", "png", "las", "tiles", "grid"};
  return formats;
}

Products write_products(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                        const ProductOptions& options, const std::filesystem::path& directory) {
  check(options.formats);
  return Writer(poses, clouds, config, options, directory).write();
}

}  // namespace lidar_mapping::map
