// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include "drive_input.hpp"
#include "parameters/stage_files.hpp"

namespace lidar_mapping::tools {

/// Which recording is read, and with which parameters: what map_bag and localize_bag have in
/// common.
struct DriveArguments {
  recordings::DriveSelection drive;
  ParameterSources parameters;
  double start = 0.0;     ///< length of the beginning that is left out, s
  double duration = 0.0;  ///< length of the part that is read, s; 0: to the end
  int threads = 0;        ///< 0: all cores
};

/// Adds the sources of parameters as options.
void add_parameter_options(CLI::App& app, ParameterSources& parameters);
/// Adds the topics of a recording as options.
void add_topic_options(CLI::App& app, ros_border::SensorTopics& topics);
/// Adds all of them but the paths as options.
void add_drive_options(CLI::App& app, DriveArguments& arguments);

/// Reads the parameters of all stages. The number of threads of the pipeline is that of the
/// command, and the frame of the drive that of the parameters. Throws ConfigError and FileError.
StageFiles read_stages(DriveArguments& arguments);

}  // namespace lidar_mapping::tools
