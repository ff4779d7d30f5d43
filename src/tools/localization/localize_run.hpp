// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <string>
#include <vector>

#include "recording/drive_arguments.hpp"

namespace lidar_mapping::tools {

/// Options of localize_bag.
struct LocalizingOptions : DriveArguments {
  std::string map;  ///< folder of a session
  std::string output;
  std::vector<double> initial_pose;  ///< x y z (m) roll pitch yaw (degrees) in map; empty: none
  /// Folder of a new session for the map and what of the drive is new to it; empty: none.
  std::string extend;
  std::string figures;  ///< path of a JSON file for times and counts; empty: none
};

/// Localises the recording in the map, writes the results and prints messages and figures. Returns
/// the exit status of localize_bag, see doc/localization.md. The drive ends early when a signal
/// handler sets `stop_requested`. Throws Error.
int localize_recording(const LocalizingOptions& options,
                       const volatile std::sig_atomic_t& stop_requested);

}  // namespace lidar_mapping::tools
