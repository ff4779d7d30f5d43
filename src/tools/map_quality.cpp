// Tells how good the map of a session is, without truth.

#include "lidar_mapping/map/map_quality.hpp"

#include <algorithm>
#include <iostream>
#include <optional>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/session/session.hpp"

namespace {

using namespace lidar_mapping;
using Json = nlohmann::ordered_json;
using session::Session;

struct Options {
  std::string session;
  std::string json;
  double range_noise = 0.02;
  std::size_t places = 10;
  std::vector<double> sensor_origin;
};

constexpr double kDegrees = 180.0 / M_PI;

KeyFramePoses poses_of(const Session& session) {
  map::KeyFrameTrack track;
  for (const KeyFrame& key_frame : session.key_frames()) track.add(key_frame);
  track.update(session.poses());
  return track.poses();
}

/// From the command line, or else from the session.
std::optional<Eigen::Vector3d> sensor_origin_of(const Options& options, const Session& session) {
  if (options.sensor_origin.size() == 3) return Eigen::Vector3d(options.sensor_origin.data());
  return session.sensor_origin();
}

/// Without the place of the sensor nobody knows how beams met the surfaces: no ratio then.
Json to_json(const map::Thickness& thickness, bool has_ratio) {
  return {{"cells", thickness.cells},
          {"median_m", thickness.median},
          {"p90_m", thickness.high},
          {"median_ratio_to_noise", has_ratio ? Json(thickness.median_ratio) : Json()}};
}

Json to_json(const map::GhostVector& ghost) {
  return {{"key_frame", ghost.key_frame},
          {"position", {ghost.position.x(), ghost.position.y(), ghost.position.z()}},
          {"along_m", ghost.along},
          {"left_m", ghost.left},
          {"up_m", ghost.up},
          {"yaw_deg", ghost.yaw * kDegrees},
          {"planes", ghost.planes},
          {"left_over_m", ghost.residual}};
}

void print(const char* name, const map::Thickness& thickness, bool has_ratio) {
  std::printf("%-7s thickness: median %5.1f mm, 90 %% below %5.1f mm (%zu cells)", name,
              1000.0 * thickness.median, 1000.0 * thickness.high, thickness.cells);
  has_ratio ? std::printf(", %.2f of the noise\n", thickness.median_ratio) : std::printf("\n");
}

void print(const std::vector<map::GhostVector>& ghosts, std::size_t places) {
  if (ghosts.empty()) {
    std::printf("no place was driven twice, so only local quality could be judged\n");
    return;
  }
  std::printf("%zu places were driven twice; how the later pass lies, worst first:\n",
              ghosts.size());
  std::printf("  key frame       x       y   along mm  left mm   up mm  yaw deg  planes\n");
  for (std::size_t i = 0; i < std::min(places, ghosts.size()); ++i) {
    const map::GhostVector& ghost = ghosts[i];
    std::printf("  %9u %7.1f %7.1f   %8.1f %8.1f %7.1f  %7.3f  %6zu\n", ghost.key_frame,
                ghost.position.x(), ghost.position.y(), 1000.0 * ghost.along, 1000.0 * ghost.left,
                1000.0 * ghost.up, ghost.yaw * kDegrees, ghost.planes);
  }
}

void judge(const Options& options) {
  const Session session = Session::open(options.session, Session::Access::kRead);
  map::QualityConfig config;
  config.range_noise = options.range_noise;
  const auto sensor = sensor_origin_of(options, session);
  config.p_base_sensor = sensor.value_or(Eigen::Vector3d::Zero());
  if (!sensor) {
    std::cerr << "map_quality: the session does not know where the LiDAR is in base_link; give "
                 "--sensor-origin x y z for the ratio to the noise\n";
  }
  const KeyFramePoses poses = poses_of(session);
  const map::LocalThickness thickness = map::local_thickness(poses, session.clouds(), config);
  auto ghosts = map::ghost_vectors(poses, session.clouds(), config);
  std::stable_sort(ghosts.begin(), ghosts.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  print("ground", thickness.ground, sensor.has_value());
  print("wall", thickness.walls, sensor.has_value());
  std::printf("planar share %.2f\n", thickness.planar_share);
  print(ghosts, options.places);
  if (options.json.empty()) return;
  Json result = {{"ground", to_json(thickness.ground, sensor.has_value())},
                 {"walls", to_json(thickness.walls, sensor.has_value())},
                 {"planar_share", thickness.planar_share},
                 {"ghosts", Json::array()}};
  for (const map::GhostVector& ghost : ghosts) result["ghosts"].push_back(to_json(ghost));
  write_text_atomically(options.json, result.dump(2) + "\n");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Tells how good the map of a session is, without truth"};
  Options options;
  app.add_option("session", options.session, "folder of the session, or a folder with `latest`")
      ->required();
  app.add_option("--range-noise", options.range_noise,
                 "standard deviation of the sensor's ranges, m; 0.02 if left out")
      ->check(CLI::PositiveNumber);
  app.add_option("--places", options.places, "places to print; 10 if left out");
  app.add_option("--sensor-origin", options.sensor_origin, "the LiDAR in base_link, m; as recorded")
      ->expected(3);
  app.add_option("--json", options.json, "write all figures to this file");
  CLI11_PARSE(app, argc, argv);
  try {
    judge(options);
  } catch (const Error& error) {
    std::cerr << "map_quality: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
