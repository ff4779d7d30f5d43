// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidar_mapping::tools {

/// What --config says in the help of every command.
constexpr const char* kConfigHelp = "folder of <stage>.yaml files, or one of them";

/// The file of a stage in what --config names: a folder of <stage>.yaml files, or one such file.
/// Empty if it has none of that stage, or nothing is named. Throws FileError if there is neither.
std::string stage_file(const std::string& config, const std::string& stage);

/// The same for a command that knows this stage alone, to which a file of any name is that of the
/// stage. Throws FileError, too, for a folder without it.
std::string only_stage_file(const std::string& config, const std::string& stage);

}  // namespace lidar_mapping::tools
