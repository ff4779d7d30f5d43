// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <functional>

#include "lidar_mapping/pipeline/input.hpp"

namespace lidar_mapping::tools {

/// The part of a recording that --start and --duration (s; 0: to the end) choose.
class RecordingPart {
 public:
  /// Throws InputError if the recording ends before it.
  RecordingPart(const pipeline::InputSource& input, double start, double duration);

  Stamp begin() const { return begin_; }
  Stamp end() const { return end_; }
  /// Where it ends before the recording does, otherwise after any stamp.
  Stamp limit() const { return limit_; }

 private:
  Stamp begin_;
  Stamp end_;
  Stamp limit_;
};

/// Calls `use` for the data of a recording up to `limit`, until the recording ends or a signal
/// handler sets `stop_requested`. A single stamp may be wrong, so several scans in a row have to be
/// behind the limit before it ends there.
void read_until(Stamp limit, const volatile std::sig_atomic_t& stop_requested,
                pipeline::InputSource& input, const std::function<void(pipeline::Input&&)>& use);

}  // namespace lidar_mapping::tools
