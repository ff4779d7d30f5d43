// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidar_mapping::tools {

/// Text about --config in the help of every command.
constexpr const char* kConfigHelp = "folder of <stage>.yaml files, or one of them";

/// The file of a stage by --config, which names a folder of <stage>.yaml files or one such file.
/// Empty if there is none of that stage, or without --config. Throws FileError if the path does not
/// exist.
std::string stage_file(const std::string& config, const std::string& stage);

/// The same for a command with this stage only, for which a file of any name is that of the stage.
/// Throws FileError also for a folder without it.
std::string only_stage_file(const std::string& config, const std::string& stage);

}  // namespace lidar_mapping::tools
