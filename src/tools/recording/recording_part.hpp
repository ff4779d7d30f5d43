// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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

/// Detects the end of the part of a recording that is read. A single stamp may be wrong, so several
/// scans in a row have to be behind the end.
class EndOfPart {
 public:
  explicit EndOfPart(Stamp end) : end_(end) {}

  /// True for data behind the end.
  bool is_behind(const pipeline::Input& input);
  bool is_over() const { return scans_ >= kCertain; }

 private:
  /// Number of scans behind the end at which it is certain; chosen: more would only read further.
  static constexpr int kCertain = 5;
  Stamp end_;
  int scans_ = 0;  ///< in a row behind the end
};

}  // namespace lidar_mapping::tools
