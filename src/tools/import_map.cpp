// SPDX-License-Identifier: BSD-3-Clause
// Makes a session of a point-cloud map that was made elsewhere, for localisation in it.

#include <cstdio>
#include <ctime>

#include <CLI/CLI.hpp>

#include "command_line/child_program.hpp"
#include "command_line/number_checks.hpp"
#include "command_line/process_memory.hpp"
#include "command_line/progress_bar.hpp"
#include "command_line/run_command.hpp"
#include "map_import.hpp"
#include "run_record.hpp"

namespace lidar_mapping::tools {

namespace {

using session::Session;

struct Options {
  map_import::ImportOptions settings;
  std::vector<double> datum;  ///< latitude, longitude (deg), altitude (m); empty: none given
  std::string output;
  std::string command;  ///< as it was typed
};

void add_arguments(CLI::App& app, Options& options) {
  map_import::ImportOptions& settings = options.settings;
  app.add_option("map", settings.map,
                 "a PCD file, or a folder of PCD files: tiles in Autoware's layout, as build_map "
                 "writes them, too")
      ->required();
  app.add_option("-o,--output", options.output, "new folder for the session")->required();
  app.add_option("--trajectory", settings.trajectory,
                 "poses of base_link in the map (TUM or KITTI), along which places are taken; "
                 "without it they are found on the ground of the map");
  // Chosen: a match counts up to 7.5 m from a key frame (max_loop_distance of loop closing).
  app.add_option("--spacing", settings.spacing, "least distance of two places, m")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 7.0));
  app.add_option("--sensor-height", settings.sensor_height, "the LiDAR above the ground, m")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 10.0));
  app.add_option("--base-height", settings.base_height,
                 "base_link above the ground, m, in the drives that are to be localised")
      ->capture_default_str()
      ->check(CLI::Range(-10.0, 10.0));
  app.add_option("--resolution", settings.resolution, "edge of the voxels that thin the map, m")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 0.5));
  app.add_option("--datum", options.datum,
                 "latitude, longitude (degrees) and height above the ellipsoid (m) of the origin "
                 "of the map, if its axes are east, north and up; as a file beside the map says, "
                 "if left out")
      ->expected(3);
  app.add_option("--threads", settings.threads, "at most so many threads; 0: all cores")
      ->check(not_negative());
}

report::RunRecord record_of(const Options& options) {
  report::RunRecord record;
  record.software = std::string("lidar_mapping ") + LIDAR_MAPPING_VERSION;
  record.command = options.command;
  record.date = report::utc(std::time(nullptr));
  record.files = {report::recorded_file(options.settings.map)};
  record.sensors = {"none: a map from elsewhere, whose key frames were computed from it"};
  record.is_complete = true;
  return record;
}

void import_map(Options& options) {
  if (!options.datum.empty()) {
    options.settings.datum = GeodeticDatum{options.datum[0], options.datum[1], options.datum[2]};
  }
  ProgressBar bar("key frames", 0);
  std::size_t places = 0;
  session::create_filled(options.output, [&](Session& session) {
    map_import::import_map(
        options.settings, session,
        [](const std::string& line) {
          std::printf("%s\n", line.c_str());
          std::fflush(stdout);
        },
        [&](std::size_t done, std::size_t all) {
          if (all != places) bar = ProgressBar("key frames", places = all);
          bar.show(done);
        });
    report::write_run_record(session.directory(), record_of(options));
  });
  std::printf("session in %s\n", options.output.c_str());
}

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app{"Makes a session of a map from elsewhere, in which drives are localised"};
  tools::Options options;
  options.settings.threads = 0;
  tools::add_arguments(app, options);
  return tools::run_command(app, argc, argv, [&] {
    options.command = tools::command_line({argv, argv + argc});
    const tools::ReturnedMemory returned_memory;
    tools::import_map(options);
  });
}
