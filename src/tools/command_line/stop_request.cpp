// SPDX-License-Identifier: BSD-3-Clause
#include "command_line/stop_request.hpp"

#include <unistd.h>

namespace lidar_mapping::tools {

namespace {

// Exit status, by definition that of shells for a process that SIGINT ended.
constexpr int kStoppedAtOnce = 130;

volatile std::sig_atomic_t stop_requested = 0;

extern "C" void request_stop(int) {
  if (stop_requested != 0) _exit(kStoppedAtOnce);
  stop_requested = 1;
}

}  // namespace

const volatile std::sig_atomic_t& stop_on_signals() {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  return stop_requested;
}

}  // namespace lidar_mapping::tools
