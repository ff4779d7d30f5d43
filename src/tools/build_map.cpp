// Builds the map of a session from its newest poses.

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/map_products.hpp"
#include "lidar_mapping/map/moving_objects.hpp"
#include "lidar_mapping/map/top_view.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

namespace {

using namespace lidar_mapping;
using map::MapConfig;
using session::Session;

struct Options {
  std::string session;
  std::string output;
  double resolution = 0.0;
  double tile_size = 0.0;
  double pixel = 0.2;
  int threads = 0;
  bool keep_moving = false;
  bool save_removed = false;
  std::vector<double> sensor_origin;
  std::vector<std::string> formats = {"pcd", "ply", "png"};
};

const std::vector<std::string> kFormats = {"pcd", "ply", "png", "las", "tiles", "grid"};

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
    std::cerr << "build_map: the session does not know where the LiDAR is in base_link, so points "
                 "of moving objects stay; give --sensor-origin x y z to remove them\n";
  }
  return origin;
}

/// A session, and everything that is made of it.
class Products {
 public:
  explicit Products(const Options& options)
      : options_(options),
        session_(Session::open(options.session, Session::Access::kRead)),
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

  void make() {
    make_clouds();
    make_tiled();
    if (options_.save_removed && fixed_) save_removed();
    for (const auto& file : files_) std::printf("%s\n", file.c_str());
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
    const PointCloud cloud = map::build_map(poses_, clouds(), config_);
    std::printf("%zu points of %zu key frames\n", cloud.size(), poses_.poses.size());
    if (!formats.empty()) {
      add(map::save_map(cloud, {"map", session_.datum(), config_.resolution}, directory_, formats));
    }
    if (wants(options_, "png")) {
      map::write_png(directory_ / "top_view.png", map::top_view(cloud, options_.pixel));
      add({directory_ / "top_view.png"});
    }
    if (wants(options_, "grid")) add(map::save_grid(cloud, {}, directory_));
  }

  /// Products that need no more memory than some tiles.
  void make_tiled() {
    const map::TileSource tiles = [this](const map::TileSink& sink) {
      map::build_tiles(poses_, clouds(), config_, sink);
    };
    if (wants(options_, "tiles")) {
      const auto folder = directory_ / "pointcloud_map";
      map::save_tiles(tiles, map::true_tile_size(config_), folder);
      add({folder});
    }
    if (wants(options_, "las")) {
      map::write_las(directory_ / "map.las", tiles, session_.datum(), max_intensity());
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

  const Options options_;
  const Session session_;
  const MapConfig config_;
  const KeyFramePoses poses_;
  const std::filesystem::path directory_;
  std::unique_ptr<map::StaticClouds> fixed_;
  map::Files files_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Builds the map of a session from its newest poses"};
  Options options;
  app.add_option("session", options.session, "folder of the session, or a folder with `latest`")
      ->required();
  app.add_option("-o,--output", options.output, "folder for the files; map/ of the session");
  app.add_option("--resolution", options.resolution, "edge of the voxels, m; as in the drive");
  app.add_option("--pixel", options.pixel, "size of the picture's pixels, m")
      ->check(CLI::PositiveNumber);
  app.add_option("--tile-size", options.tile_size, "edge of the tiles, m; as in the drive");
  app.add_option("--formats", options.formats,
                 "pcd, ply, png (view from above), las, tiles (Autoware), grid (map_server); "
                 "pcd,ply,png if left out")
      ->delimiter(',')
      ->check(CLI::IsMember(kFormats));
  app.add_flag("--keep-moving", options.keep_moving, "leave points of moving objects in");
  app.add_flag("--save-removed", options.save_removed, "write what was removed, too");
  app.add_option("--sensor-origin", options.sensor_origin, "the LiDAR in base_link, m")
      ->expected(3);
  app.add_option("--threads", options.threads, "at most so many threads; 0: all cores");
  CLI11_PARSE(app, argc, argv);
  try {
    Products(options).make();
  } catch (const Error& error) {
    std::cerr << "build_map: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
