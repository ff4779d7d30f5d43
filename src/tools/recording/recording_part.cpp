// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_part.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <variant>

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

void read_until(Stamp limit, const volatile std::sig_atomic_t& stop_requested,
                pipeline::InputSource& input, const std::function<void(pipeline::Input&&)>& use) {
  constexpr int kCertain = 5;  // scans behind the limit; chosen: more would only read further
  int behind = 0;              // scans in a row
  while (stop_requested == 0 && behind < kCertain) {
    auto datum = input.next();
    if (!datum) return;
    const auto* scan = std::get_if<pipeline::RecordedScan>(&*datum);
    if (scan != nullptr) behind = scan->stamp >= limit ? behind + 1 : 0;
    if (scan == nullptr || behind == 0) use(std::move(*datum));
  }
}

}  // namespace lidar_mapping::tools
