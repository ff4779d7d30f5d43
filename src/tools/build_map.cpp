// SPDX-License-Identifier: BSD-3-Clause
// Builds the map of a session from its newest poses.

#include <cstdio>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/text.hpp"

#include "command_line/number_checks.hpp"
#include "command_line/process_memory.hpp"
#include "command_line/run_command.hpp"
#include "mapping/scan_map.hpp"

namespace lidar_mapping::tools {

namespace {

struct Options {
  std::string folder;  ///< of the session
  MapOutput output;
  std::vector<double> crop;  ///< two corners, m; empty: no limit
  ScanMapInput scans;
};

void add_arguments(CLI::App& app, Options& options) {
  app.add_option("session", options.folder, "folder of the session, or a folder with `latest`")
      ->required();
  app.add_option("-o,--output", options.output.folder, "folder for the files; map/ of the session");
  app.add_option("--resolution", options.output.resolution,
                 "edge of the voxels, m; as in the drive");
  app.add_option("--pixel", options.output.products.pixel,
                 "size of the pixels of picture and geotiff, m")
      ->check(above_zero());
  app.add_option("--tile-size", options.output.tile_size, "edge of the tiles, m; as in the drive");
  app.add_option("--cell", options.output.grid_cell,
                 "edge of the grid's cells, m; as in the drive, or that of the voxels");
  app.add_option("--formats", options.output.products.formats,
                 map::product_format_help() + "; pcd,ply,png if left out")
      ->delimiter(',')
      ->check(CLI::IsMember(map::product_formats(), CLI::ignore_case));
  app.add_option("--crop", options.crop, "only points in this box of the map: x0 y0 z0 x1 y1 z1, m")
      ->expected(6);
  app.add_option("--poses", options.output.poses,
                 "TUM file with poses of the key frames instead of those of the session "
                 "(trajectory/ground_truth.tum has those of GNSS and IMU)");
  app.add_option("--scans", options.scans.recording,
                 "the recording of the session: the map is built from all scans, not only from "
                 "the key frames");
  app.add_option("--every", options.scans.every, "with --scans: use every n-th scan")
      ->check(CLI::PositiveNumber);
  app.add_option("--scan-resolution", options.scans.resolution,
                 "with --scans: edge of the voxels to which scans are thinned, m; 0 keeps all "
                 "points; as the key frames if left out")
      ->check(not_negative());
  app.add_flag(
      "--utm", options.output.products.utm,
      joined(map::point_formats()) +
          " in UTM, relative to the datum: map.pcd.utm and its like have easting, northing "
          "and height to add (las always is in UTM)");
  app.add_flag("--keep-moving", options.output.products.keep_moving,
               "leave points of moving objects in");
  app.add_flag("--keep-outdated", options.output.products.keep_outdated,
               "leave in what later visits have looked through");
  app.add_option("--as-of", options.output.as_of,
                 "the map as it was then: only key frames up to this date, 2026-05-01 or "
                 "2026-05-01T12:00 (UTC)");
  app.add_flag("--save-removed", options.output.products.save_removed,
               "also write the removed points");
  app.add_option("--sensor-origin", options.output.sensor_origin, "the LiDAR in base_link, m")
      ->expected(3);
  app.add_option("--threads", options.output.threads, "upper limit of threads; 0: all cores")
      ->check(not_negative());
}

void build(Options& options) {
  options.output.products.crop = map::crop_box(options.crop);
  const auto session = session::Session::open(options.folder, session::Session::Access::kRead);
  const map::Files files = options.scans.recording.empty()
                               ? write_map(session, options.output)
                               : write_scan_map(session, options.output, options.scans);
  for (const auto& file : files) std::printf("%s\n", file.c_str());
}

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app{"Builds the map of a session from its newest poses"};
  tools::Options options;
  tools::add_arguments(app, options);
  return tools::run_command(app, argc, argv, [&] {
    const tools::ReturnedMemory returned_memory;
    tools::build(options);
  });
}
