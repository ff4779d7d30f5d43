// SPDX-License-Identifier: BSD-3-Clause
#include "recording/drive_arguments.hpp"

#include <algorithm>
#include <iostream>
#include <string>
#include <thread>

#include "command_line/number_checks.hpp"
#include "parameters/config_path.hpp"

namespace lidar_mapping::tools {

void add_parameter_options(CLI::App& app, ParameterSources& parameters) {
  app.add_option("--config", parameters.config,
                 std::string(kConfigHelp) + "; defaults if left out");
  app.add_option("--sensor", parameters.overlay,
                 "overlay of parameters: a name in config/sensors, or the path of a file");
  app.add_option("--preset", parameters.preset,
                 "overlay for the kind of place: a name in config/presets, or the path of a file");
  app.add_option("--parameter", parameters.parameters,
                 "a single one, as 'stage/name: value' (repeatable)")
      ->allow_extra_args(false);
}

void add_topic_options(CLI::App& app, ros_border::SensorTopics& topics) {
  app.add_option("--points", topics.points,
                 "topic (found by type if left out); of several LiDARs with commas, the main one "
                 "first");
  app.add_option("--imu", topics.imu, "topic");
  app.add_option("--velocity", topics.velocity, "topic");
  app.add_option("--gnss", topics.gnss, "topic");
}

void add_drive_options(CLI::App& app, DriveArguments& arguments) {
  add_parameter_options(app, arguments.parameters);
  add_topic_options(app, arguments.drive.topics);
  app.add_option("--sensor-height", arguments.drive.sensor_height,
                 "of folders: the LiDAR over base_link, m")
      ->capture_default_str();
  app.add_option("--start", arguments.start, "leave out so many seconds of the beginning")
      ->check(not_negative());
  app.add_option("--duration", arguments.duration, "end so many seconds after the start")
      ->check(above_zero());
  app.add_option("--threads", arguments.threads, "at most so many threads; 0: all cores")
      ->check(not_negative());
}

StageFiles read_stages(DriveArguments& arguments) {
  StageFiles stages = read_stage_files(arguments.parameters);
  for (const std::string& line : stages.replaced) std::cerr << line << "\n";
  stages.pipeline.threads =
      arguments.threads > 0 ? arguments.threads
                            : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  arguments.drive.base_frame = stages.base_frame;
  return stages;
}

}  // namespace lidar_mapping::tools
