// SPDX-License-Identifier: BSD-3-Clause
// Maps a recorded drive without a ROS master, as fast as the processor allows.

#include <CLI/CLI.hpp>

#include "command_line/child_program.hpp"
#include "command_line/process_memory.hpp"
#include "command_line/run_command.hpp"
#include "command_line/stop_request.hpp"
#include "mapping/mapping_run.hpp"

namespace lidar_mapping::tools {

namespace {

void add_arguments(CLI::App& app, MappingOptions& options) {
  app.add_option(
         "input", options.drive.paths,
         "bags of one drive (ROS 1, or .db3 or .mcap of ROS 2), a folder of them, or a folder of "
         "scans: KITTI raw, KITTI odometry, *.pcd or *.bin")
      ->required();
  app.add_option("-o,--output", options.output, "new folder for the session and the map")
      ->required();
  add_drive_options(app, options);
  app.add_flag("--resume", options.resume,
               "complete the session in the output folder: to the same bytes as without a break");
  app.add_flag("--quick-resume", options.quick_resume,
               "the same from near its end on: faster, to within centimetres");
  app.add_option("--formats", options.map.products.formats, "of the map, as build_map has them")
      ->delimiter(',')
      ->check(CLI::IsMember(map::product_formats(), CLI::ignore_case));
  app.add_option("--resolution", options.map.resolution, "edge of the map's voxels, m");
  app.add_flag("--keep-moving", options.map.products.keep_moving,
               "leave points of moving objects in the map");
  app.add_flag("--no-map", options.no_map, "the session alone; build_map makes a map of it later");
  app.add_flag("--report", options.report,
               "check the quality of the map and write report.html, as map_quality does");
  app.add_flag("--allow-doubt", options.allow_doubt,
               "end with status 0 even if parts of the map cannot be trusted");
  app.add_option("--figures", options.figures, "write times and counts to this JSON file");
  app.footer(
      "exit status: 0 success; 1 no map, the message has the reason; 3 stopped early by Ctrl-C, "
      "with "
      "a complete map of the drive so far; 4 parts of the map cannot be trusted (listed at the end "
      "and in doubt.csv), unless --allow-doubt; 130 ended at once by a second Ctrl-C");
}

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app{"Maps a recorded drive without a ROS master, as fast as the processor allows"};
  tools::MappingOptions options;
  tools::add_arguments(app, options);
  return tools::run_command(app, argc, argv, [&] {
    options.command = tools::command_line({argv, argv + argc});
    const tools::ReturnedMemory returned_memory;
    return tools::map_recording(options, tools::stop_on_signals());
  });
}
