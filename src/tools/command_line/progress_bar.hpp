// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>

#include <unistd.h>

namespace lidar_mapping::tools {

/// Progress on stderr: a bar on a terminal, otherwise a line for every tenth.
class ProgressBar {
 public:
  ProgressBar(std::string what, std::size_t total) : what_(std::move(what)), total_(total) {}

  void show(std::size_t done) {
    const int percent = total_ == 0 ? 100 : static_cast<int>(100 * done / total_);
    if (percent == shown_percent_) return;
    if (terminal_) {
      const std::string bar(static_cast<std::size_t>(percent) / 2, '=');
      std::fprintf(stderr, "\r%s [%-50s] %3d %% (%zu of %zu)%s", what_.c_str(), bar.c_str(),
                   percent, done, total_, percent == 100 ? "\n" : "");
    } else if (percent / 10 != shown_percent_ / 10) {
      std::fprintf(stderr, "%s: %d %% (%zu of %zu)\n", what_.c_str(), percent, done, total_);
    }
    shown_percent_ = percent;
  }

 private:
  std::string what_;
  std::size_t total_;
  bool terminal_ = isatty(STDERR_FILENO) != 0;
  int shown_percent_ = 0;
};

}  // namespace lidar_mapping::tools
