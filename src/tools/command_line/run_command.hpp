// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <iostream>
#include <type_traits>

#include <CLI/CLI.hpp>

namespace lidar_mapping::tools {

/// Reads the command line and calls `run`, whose result, if it has one, is the exit status. If it
/// throws, its error is printed behind the command's name, and the exit status is `failed`.
template <typename Run>
int run_command(CLI::App& app, int argc, char** argv, const Run& run, int failed = 1) {
  try {
    app.parse(argc, argv);
    if constexpr (!std::is_void_v<std::invoke_result_t<Run>>)
      return run();
    else
      run();
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);  // prints it, or the help
  } catch (const std::exception& error) {
    std::cerr << std::filesystem::path(argv[0]).filename().string() << ": " << error.what() << "\n";
    return failed;
  }
}

}  // namespace lidar_mapping::tools
