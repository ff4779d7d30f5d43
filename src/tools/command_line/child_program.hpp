// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lidar_mapping::tools {

/// Runs a program with these arguments, without a shell that would interpret them, and waits for
/// its end. Throws FileError if it cannot be started, does not end with status 0 or is ended by a
/// signal.
void run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments);

/// Path of a program or script of this package, in the folder of the running one.
std::filesystem::path program_beside(const std::string& name);

/// The words as a command line for a shell: those with special characters in quotes.
std::string command_line(const std::vector<std::string>& words);

}  // namespace lidar_mapping::tools
