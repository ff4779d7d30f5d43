// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <string>

#include "mapping/map_output.hpp"
#include "recording/drive_arguments.hpp"

namespace lidar_mapping::tools {

/// Options of map_bag.
struct MappingOptions : DriveArguments {
  std::string output;
  std::string figures;  ///< path of a JSON file for times and counts; empty: none
  std::string command;  ///< as it was typed
  bool resume = false;
  bool quick_resume = false;
  bool no_map = false;
  bool report = false;
  bool allow_doubt = false;
  MapOutput map;
};

/// Maps the recording into the output folder and prints messages, figures and warnings. Returns the
/// exit status of map_bag, see doc/pipeline.md. The drive ends early when a signal handler sets
/// `stop_requested`. Throws Error.
int map_recording(const MappingOptions& options, const volatile std::sig_atomic_t& stop_requested);

}  // namespace lidar_mapping::tools
