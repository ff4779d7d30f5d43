// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapping_progress.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include <unistd.h>

#include "command_line/process_memory.hpp"

namespace lidar_mapping::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRefresh{200};
constexpr double kMegabyte = 1e6;  // bytes, by SI

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

std::string bar_of(double fraction) {
  constexpr std::size_t kWidth = 24;  // characters; chosen: the rest of the line is for figures
  std::string bar(static_cast<std::size_t>(fraction * kWidth), '=');
  bar.resize(kWidth, ' ');
  return "[" + bar + "]";
}

}  // namespace

MappingProgress::MappingProgress(Stamp begin, Stamp end)
    : begin_(begin),
      end_(end),
      mapped_from_(begin),
      terminal_(isatty(STDERR_FILENO) != 0),
      shown_(start_) {}

double MappingProgress::seconds() const { return seconds_between(start_, Clock::now()); }

void MappingProgress::show(const pipeline::Progress& progress) {
  if (progress.scans == 0) return;
  const double whole = std::max(1e-3, to_seconds(end_ - begin_));
  const double driven = std::clamp(to_seconds(progress.newest - begin_), 0.0, whole);
  const double fraction = driven / whole;
  const auto now = Clock::now();
  const int tenth = static_cast<int>(10.0 * fraction);
  if (terminal_ ? now - shown_ < kRefresh : tenth == shown_tenth_) return;
  shown_ = now;
  shown_tenth_ = tenth;
  const double spent = seconds();
  const double speed = std::max(0.0, to_seconds(progress.newest - mapped_from_)) / spent;
  const double left = speed > 0.0 ? (whole - driven) / speed : 0.0;
  std::fprintf(stderr,
               "%s%s %3.0f %%, %.0f of %.0f s driven, %.1f x real time, %zu key frames, "
               "%zu loops, %.0f MB, %.0f s left%s",
               terminal_ ? "\r\033[K" : "",
               terminal_ ? bar_of(fraction).c_str() : "mapping:", 100.0 * fraction, driven, whole,
               speed, progress.key_frames, progress.loops,
               static_cast<double>(resident_bytes()) / kMegabyte, left, terminal_ ? "" : "\n");
  open_line_ = terminal_;
}

void MappingProgress::end_line() {
  if (open_line_) std::fputc('\n', stderr);
  open_line_ = false;
}

}  // namespace lidar_mapping::tools
