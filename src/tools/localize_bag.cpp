// SPDX-License-Identifier: BSD-3-Clause
// Finds a recorded drive in a finished map and follows it there, without a ROS master.

#include <CLI/CLI.hpp>

#include "command_line/process_memory.hpp"
#include "command_line/run_command.hpp"
#include "command_line/stop_request.hpp"
#include "localization/localize_run.hpp"

namespace lidar_mapping::tools {

namespace {

void add_arguments(CLI::App& app, std::vector<std::string>& paths, LocalizingOptions& options) {
  app.add_option("drive_and_map", paths,
                 "DRIVE... MAP: what map_bag reads as one drive (bags, a folder of them, or a "
                 "folder of scans), and at the end the map: the folder of a session")
      ->required()
      ->expected(2, -1);
  app.add_option("-o,--output", options.output, "new folder for the results")->required();
  app.add_option("--initial-pose", options.initial_pose,
                 "pose of the first scan in the map, right to some metres: X Y Z (m) ROLL PITCH "
                 "YAW (degrees); none is needed")
      ->expected(6);
  app.add_option("--extend", options.extend,
                 "new folder for a session of the map and what of the drive is new to it");
  add_drive_options(app, options);
  app.add_option("--figures", options.figures, "write times and counts to this JSON file");
  app.footer(
      "exit status: 0 success; 1 no results, the message has the reason; 3 stopped early by "
      "Ctrl-C, with the results so far; 5 the drive was never found in the map; 130 ended at once "
      "by a second Ctrl-C");
}

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app{"Finds a recorded drive in a finished map, and follows it there"};
  std::vector<std::string> paths;
  tools::LocalizingOptions options;
  tools::add_arguments(app, paths, options);
  return tools::run_command(app, argc, argv, [&] {
    options.map = paths.back();
    options.drive.paths.assign(paths.begin(), paths.end() - 1);
    const tools::ReturnedMemory returned_memory;
    return tools::localize_recording(options, tools::stop_on_signals());
  });
}
