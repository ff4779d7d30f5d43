// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lidar_mapping::tools {

/// Runs a program with these words as its arguments, each handed over as it is (no shell reads
/// them), and waits for its end. Throws FileError if it cannot be started, does not end with
/// status 0 or is ended by a signal.
void run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments);

/// A program or script of this package, which lies beside the one that runs.
std::filesystem::path program_beside(const std::string& name);

/// The words as a person would type them into a shell: those with special characters in quotes.
std::string command_line(const std::vector<std::string>& words);

}  // namespace lidar_mapping::tools
