// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "lidar_mapping/pipeline/pipeline.hpp"

namespace lidar_mapping::tools {

/// Shows how far a drive is mapped: a bar on a terminal, a line for every tenth of the drive
/// elsewhere; both on stderr.
class MappingProgress {
 public:
  MappingProgress(Stamp begin, Stamp end);

  /// What lies before was mapped by an earlier run: it counts as driven, but not for the speed.
  void begin_at(Stamp stamp) { mapped_from_ = stamp; }
  void show(const pipeline::Progress& progress);
  /// Ends the bar's line, so that other text can follow.
  void end_line();
  /// Wall time since the beginning, s.
  double seconds() const;

 private:
  Stamp begin_;
  Stamp end_;
  Stamp mapped_from_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point shown_;
  int shown_tenth_ = 0;
  bool open_line_ = false;
};

}  // namespace lidar_mapping::tools
