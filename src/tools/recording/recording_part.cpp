// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_part.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::tools {

namespace {

/// The time so many seconds after `begin`, at most `end`. No stamp holds the sum of any number.
Stamp time_after(Stamp begin, double seconds, Stamp end) {
  if (seconds >= to_seconds(end - begin)) return end;
  return std::min(end, begin + from_seconds(seconds));
}

}  // namespace

RecordingPart chosen_part(const pipeline::InputSource& input, double start, double duration) {
  RecordingPart part{input.begin(), input.end(), std::numeric_limits<Stamp>::max()};
  if (start > 0.0) part.begin = time_after(input.begin(), start, input.end());
  if (part.begin >= part.end && start > 0.0) {
    throw InputError(formatted("--start %.10g: the recording lasts %f s", start,
                               to_seconds(input.end() - input.begin())));
  }
  if (duration <= 0.0) return part;
  part.end = time_after(part.begin, duration, input.end());
  if (part.end < input.end()) part.limit = part.end;
  return part;
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
