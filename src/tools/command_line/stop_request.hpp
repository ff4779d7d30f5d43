// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>

namespace lidar_mapping::tools {

/// From now on SIGINT and SIGTERM set the returned value to 1, so that a command can end with what
/// it has; a second signal ends the process at once, with the exit status of shells for that (130).
const volatile std::sig_atomic_t& stop_on_signals();

}  // namespace lidar_mapping::tools
