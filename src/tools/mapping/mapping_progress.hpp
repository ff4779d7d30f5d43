// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "lidar_mapping/pipeline/pipeline.hpp"

namespace lidar_mapping::tools {

/// Shows the progress of mapping on stderr: a bar on a terminal, otherwise a line for every tenth
/// of the drive.
class MappingProgress {
 public:
  MappingProgress(Stamp begin, Stamp end);

  /// Sets the beginning of this run. The part before was mapped by an earlier run and does not
  /// count for the speed.
  void begin_at(Stamp stamp) { mapped_from_ = stamp; }
  void show(const pipeline::Progress& progress);
  /// Ends the line of the bar, so that other text can follow.
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
