#include "map_output.hpp"

#include <cstdio>
#include <iostream>

#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

namespace lidar_mapping::tools {

namespace {

using map::MapConfig;
using session::Session;

/// Clouds are read in the order of the drive, first as witnesses and thirty key frames later to be
/// judged and put into the map: so much is between the two with 50,000 points each.
constexpr std::size_t kCacheBytes = session::CloudStore::kDefaultCacheBytes / 2;

/// `stored`, and over it the command line.
MapConfig make_config(const MapOutput& output, const config::Source& stored) {
  std::vector<config::Source> sources = {stored};
  if (output.resolution) {
    sources.push_back({"--resolution", {config::Value::Map{{"resolution", {*output.resolution}}}}});
  }
  if (output.tile_size) {
    sources.push_back({"--tile-size", {config::Value::Map{{"tile_size", {*output.tile_size}}}}});
  }
  MapConfig config = config::load<MapConfig>(sources);
  config.threads = output.threads;
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
std::optional<Eigen::Vector3d> sensor_origin_of(const MapOutput& output, const Session& session) {
  if (output.keep_moving) return std::nullopt;
  if (output.sensor_origin.size() == 3) return Eigen::Vector3d(output.sensor_origin.data());
  const auto origin = session.sensor_origin();
  if (!origin) {
    std::cerr << "the session does not know where the LiDAR is in base_link, so points "
                 "of moving objects stay; give --sensor-origin x y z to remove them\n";
  }
  return origin;
}

}  // namespace

void check_numbers(const MapOutput& output) { make_config(output, {}); }

map::Files write_map(const Session& session, const MapOutput& output) {
  const MapConfig config = make_config(output, pipeline::stored_configuration<MapConfig>(session));
  map::ProductOptions options = output.products;
  options.datum = session.datum();
  options.p_base_sensor = sensor_origin_of(output, session);
  const KeyFramePoses poses = poses_of(session);
  session.clouds().set_cache_bytes(kCacheBytes);
  const auto folder =
      output.folder.empty() ? session.directory() / "map" : std::filesystem::path(output.folder);
  const map::Products products =
      map::write_products(poses, session.clouds(), config, options, folder);
  std::printf("%zu points of %zu key frames\n", products.points, poses.poses.size());
  if (options.save_removed) std::printf("%zu points of moving objects\n", products.removed);
  return products.files;
}

}  // namespace lidar_mapping::tools
