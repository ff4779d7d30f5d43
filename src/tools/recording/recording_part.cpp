// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_part.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::tools {

RecordingPart::RecordingPart(const pipeline::InputSource& input, double start, double duration)
    : begin_(input.begin() + from_seconds(start)),
      end_(input.end()),
      limit_(std::numeric_limits<Stamp>::max()) {
  if (begin_ >= end_ && start > 0.0) {
    throw InputError("--start " + std::to_string(start) + ": the recording lasts " +
                     std::to_string(to_seconds(input.end() - input.begin())) + " s");
  }
  if (duration <= 0.0) return;
  end_ = std::min(end_, begin_ + from_seconds(duration));
  limit_ = end_;
}

bool EndOfPart::is_behind(const pipeline::Input& input) {
  const auto* scan = std::get_if<pipeline::RecordedScan>(&input);
  if (scan == nullptr) return false;
  scans_ = scan->stamp >= end_ ? scans_ + 1 : 0;
  return scans_ > 0;
}

}  // namespace lidar_mapping::tools
