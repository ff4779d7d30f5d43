#include "map_output.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/map_products.hpp"
#include "lidar_mapping/map/moving_objects.hpp"
#include "lidar_mapping/map/top_view.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

namespace lidar_mapping::tools {

namespace {

using map::MapConfig;
using session::Session;
using Options = ProductOptions;

bool wants(const Options& options, const std::string& format) {
  return std::find(options.formats.begin(), options.formats.end(), format) != options.formats.end();
}

MapConfig make_config(const Options& options, const Session& session) {
  MapConfig config = config::load<MapConfig>({pipeline::stored_configuration<MapConfig>(session)});
  if (options.resolution > 0.0) config.resolution = options.resolution;
  if (options.tile_size > 0.0) config.tile_size = options.tile_size;
  config.threads = options.threads;
  return config;
}

/// Optimised poses, and odometry behind the last of them.
KeyFramePoses poses_of(const Session& session) {
  map::KeyFrameTrack track;
  for (const KeyFrame& key_frame : session.key_frames()) track.add(key_frame);
  track.update(session.poses());
  return track.poses();
}

/// From the command line, or else from the session; none if the points that move are to stay.
std::optional<Eigen::Vector3d> sensor_origin_of(const Options& options, const Session& session) {
  if (options.keep_moving) return std::nullopt;
  if (options.sensor_origin.size() == 3) return Eigen::Vector3d(options.sensor_origin.data());
  const auto origin = session.sensor_origin();
  if (!origin) {
    std::cerr << "the session does not know where the LiDAR is in base_link, so points "
                 "of moving objects stay; give --sensor-origin x y z to remove them\n";
  }
  return origin;
}

/// A session, and everything that is made of it.
class Products {
 public:
  Products(const Session& session, const Options& options)
      : options_(options),
        session_(session),
        config_(make_config(options, session_)),
        poses_(poses_of(session_)),
        directory_(options.output.empty() ? session_.directory() / "map"
                                          : std::filesystem::path(options.output)) {
    if (const auto origin = sensor_origin_of(options, session_)) {
      map::MovingObjectsConfig removal;
      removal.threads = options.threads;
      fixed_ = std::make_unique<map::StaticClouds>(session_.clouds(), poses_, *origin, removal);
    }
  }

  map::Files make() {
    make_clouds();
    make_tiled();
    if (options_.save_removed && fixed_) save_removed();
    return files_;
  }

 private:
  CloudSource& clouds() {
    if (fixed_) return *fixed_;
    return session_.clouds();
  }

  void make_clouds() {
    std::vector<std::string> formats;
    for (const char* format : {"pcd", "ply"}) {
      if (wants(options_, format)) formats.emplace_back(format);
    }
    if (formats.empty() && !wants(options_, "png") && !wants(options_, "grid")) return;
    const map::CloudParts points = map::stored_parts(tiles(), directory_);
    std::size_t count = 0;
    points.each([&](const PointCloud& part) { count += part.size(); });
    std::printf("%zu points of %zu key frames\n", count, poses_.poses.size());
    if (!formats.empty()) {
      add(map::save_map(points, {"map", session_.datum(), config_.resolution}, directory_,
                        formats));
    }
    if (wants(options_, "png")) {
      map::write_png(directory_ / "top_view.png", map::top_view(points, options_.pixel));
      add({directory_ / "top_view.png"});
    }
    if (wants(options_, "grid")) add(map::save_grid(points, {}, directory_));
  }

  map::TileSource tiles() {
    return [this](const map::TileSink& sink) { map::build_tiles(poses_, clouds(), config_, sink); };
  }

  void make_tiled() {
    if (wants(options_, "tiles")) {
      const auto folder = directory_ / "pointcloud_map";
      map::save_tiles(tiles(), map::true_tile_size(config_), folder);
      add({folder});
    }
    if (wants(options_, "las")) {
      map::write_las(directory_ / "map.las", tiles(), session_.datum(), max_intensity());
      add({directory_ / "map.las"});
    }
  }

  float max_intensity() {
    float largest = 0.0F;
    for (const KeyFramePose& pose : poses_.poses) {
      const PointCloudPtr cloud = session_.clouds().cloud(pose.index);
      if (!cloud) continue;
      for (const Point& point : cloud->points) largest = std::max(largest, point.intensity);
    }
    return largest;
  }

  void save_removed() {
    PointCloud all;
    for (const KeyFramePose& pose : poses_.poses) {
      const PointCloudPtr part = fixed_->removed(pose.index);
      if (!part) continue;
      const PointCloud placed = transformed(*part, pose.T_map_base);
      all.points.insert(all.points.end(), placed.points.begin(), placed.points.end());
    }
    std::printf("%zu points of moving objects\n", all.size());
    if (all.empty()) return;
    map::write_pcd(directory_ / "moving_objects.pcd", all);
    add({directory_ / "moving_objects.pcd"});
  }

  void add(const map::Files& files) { files_.insert(files_.end(), files.begin(), files.end()); }

  const Options& options_;
  const Session& session_;
  const MapConfig config_;
  const KeyFramePoses poses_;
  const std::filesystem::path directory_;
  std::unique_ptr<map::StaticClouds> fixed_;
  map::Files files_;
};

}  // namespace

const std::vector<std::string>& product_formats() {
  static const std::vector<std::string> formats = {"pcd", "ply", "png", "las", "tiles", "grid"};
  return formats;
}

map::Files write_products(const Session& session, const ProductOptions& options) {
  return Products(session, options).make();
}

}  // namespace lidar_mapping::tools
