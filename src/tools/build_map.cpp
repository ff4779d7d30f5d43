// SPDX-License-Identifier: BSD-3-Clause
// Builds the map of a session from its newest poses.

#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"

#include "number_checks.hpp"
#include "process_memory.hpp"
#include "scan_map.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Builds the map of a session from its newest poses"};
  using namespace lidar_mapping;
  std::string folder;
  tools::MapOutput output;
  app.add_option("session", folder, "folder of the session, or a folder with `latest`")->required();
  app.add_option("-o,--output", output.folder, "folder for the files; map/ of the session");
  app.add_option("--resolution", output.resolution, "edge of the voxels, m; as in the drive");
  app.add_option("--pixel", output.products.pixel, "size of the picture's pixels, m")
      ->check(tools::above_zero());
  app.add_option("--tile-size", output.tile_size, "edge of the tiles, m; as in the drive");
  app.add_option("--cell", output.grid_cell,
                 "edge of the grid's cells, m; as in the drive, or that of the voxels");
  app.add_option("--formats", output.products.formats,
                 map::product_format_help() + "; pcd,ply,png if left out")
      ->delimiter(',')
      ->check(CLI::IsMember(map::product_formats(), CLI::ignore_case));
  std::vector<double> crop;
  app.add_option("--crop", crop, "only what lies in this box of the map: x0 y0 z0 x1 y1 z1, m")
      ->expected(6);
  tools::ScanMapInput scans;
  app.add_option("--poses", output.poses,
                 "TUM file: where the key frames lie, instead of the session's poses (with "
                 "trajectory/ground_truth.tum they lie where GNSS and IMU have them)");
  app.add_option("--scans", scans.recording,
                 "the recording that the session was made of: its scans go into the map, not the "
                 "key frames alone");
  app.add_option("--every", scans.every, "with --scans: each so many-th scan")
      ->check(CLI::PositiveNumber);
  app.add_option("--scan-resolution", scans.resolution,
                 "with --scans: thin each scan to voxels of this edge, m; 0 keeps all points; as "
                 "the key frames if left out")
      ->check(tools::not_negative());
  app.add_flag("--utm", output.products.utm,
               "pcd and ply in UTM, relative to the datum: map.pcd.utm has easting, northing and "
               "height to add (las always is in UTM)");
  app.add_flag("--keep-moving", output.keep_moving, "leave points of moving objects in");
  app.add_flag("--save-removed", output.products.save_removed, "write what was removed, too");
  app.add_option("--sensor-origin", output.sensor_origin, "the LiDAR in base_link, m")->expected(3);
  app.add_option("--threads", output.threads, "at most so many threads; 0: all cores")
      ->check(tools::not_negative());
  CLI11_PARSE(app, argc, argv);
  const tools::ReturnedMemory returned_memory;
  try {
    output.products.crop = map::crop_box(crop);
    const auto session = session::Session::open(folder, session::Session::Access::kRead);
    const map::Files files = scans.recording.empty()
                                 ? tools::write_map(session, output)
                                 : tools::write_scan_map(session, output, scans);
    for (const auto& file : files) {
      std::printf("%s\n", file.c_str());
    }
  } catch (const std::exception& error) {
    std::cerr << "build_map: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
