// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <functional>

#include "lidar_mapping/pipeline/input.hpp"

namespace lidar_mapping::tools {

struct RecordingPart {
  Stamp begin = 0;
  Stamp end = 0;
  Stamp limit = 0;  ///< the end where the recording goes on behind it, otherwise after any stamp
};

/// The part that --start and --duration (s; 0: to the end) choose. Throws InputError if the
/// recording ends before it.
RecordingPart chosen_part(const pipeline::InputSource& input, double start, double duration);

/// Calls `use` for the data of a recording up to `limit`, until the recording ends or a signal
/// handler sets `stop_requested`. A single stamp may be wrong, so several scans in a row have to be
/// behind the limit before it ends there.
void read_until(Stamp limit, const volatile std::sig_atomic_t& stop_requested,
                pipeline::InputSource& input, const std::function<void(pipeline::Input&&)>& use);

}  // namespace lidar_mapping::tools
