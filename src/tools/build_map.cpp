// Builds the map of a session from its newest poses.

#include <iostream>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/map_files.hpp"
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
  double pixel = 0.2;
  std::vector<std::string> formats = {"pcd", "ply", "png"};
};

bool wants(const Options& options, const std::string& format) {
  return std::find(options.formats.begin(), options.formats.end(), format) != options.formats.end();
}

MapConfig make_config(const Options& options, const Session& session) {
  MapConfig config = config::load<MapConfig>({pipeline::stored_configuration<MapConfig>(session)});
  if (options.resolution > 0.0) config.resolution = options.resolution;
  return config;
}

/// Optimised poses, and odometry behind the last of them.
KeyFramePoses poses_of(const Session& session) {
  map::KeyFrameTrack track;
  for (const KeyFrame& key_frame : session.key_frames()) track.add(key_frame);
  track.update(session.poses());
  return track.poses();
}

std::vector<std::string> cloud_formats(const Options& options) {
  std::vector<std::string> formats;
  for (const char* format : {"pcd", "ply"}) {
    if (wants(options, format)) formats.emplace_back(format);
  }
  return formats;
}

void build(const Options& options) {
  const Session session = Session::open(options.session, Session::Access::kRead);
  const MapConfig config = make_config(options, session);
  const std::filesystem::path directory =
      options.output.empty() ? session.directory() / "map" : std::filesystem::path(options.output);
  const PointCloud cloud = map::build_map(poses_of(session), session.clouds(), config);
  map::Files files;
  if (const auto formats = cloud_formats(options); !formats.empty()) {
    files = map::save_map(cloud, {"map", session.datum(), config.resolution}, directory, formats);
  }
  if (wants(options, "png")) {
    files.push_back(directory / "top_view.png");
    map::write_png(files.back(), map::top_view(cloud, options.pixel));
  }
  std::printf("%zu points of %zu key frames\n", cloud.size(), session.key_frame_count());
  for (const auto& file : files) std::printf("%s\n", file.c_str());
}

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
  app.add_option("--formats", options.formats, "pcd, ply, png (view from above); all if left out")
      ->delimiter(',')
      ->check(CLI::IsMember({"pcd", "ply", "png"}));
  CLI11_PARSE(app, argc, argv);
  try {
    build(options);
  } catch (const Error& error) {
    std::cerr << "build_map: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
