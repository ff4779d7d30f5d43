// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/extension_lines.hpp"

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::pipeline {

namespace {

/// m: a shorter path is not worth a word. Chosen: it would be shown as 0 m.
constexpr double kLeastShownPathLength = 0.5;

/// New paths that were not added and why; empty without any.
std::string omitted_line(const OmittedPaths& omitted) {
  std::vector<std::string> lines;
  const auto add = [&](double length, const std::string& reason) {
    if (length >= kLeastShownPathLength)
      lines.push_back(formatted("%.0f m %s", length, reason.c_str()));
  };
  add(omitted.never_found, "that odometry does not connect to any place found in the map");
  add(omitted.too_short, formatted("in sections shorter than %g m", kLeastNewPathLength));
  add(omitted.not_tied,
      formatted("with fewer than %zu consistent constraints to the map", kLeastTies));
  return lines.empty() ? "" : "left out: " + joined(lines, "; ");
}

std::string added_line(const ExtensionReport& report) {
  double new_path_length = 0.0;
  std::size_t ties = 0;
  for (const NewSection& section : report.extension.sections) {
    new_path_length += section.new_path_length;
    ties += section.ties.size();
  }
  return formatted(
      "added to the map: %.0f m of new path in %s; %zu key frames including those of the "
      "adjacent known path, with %zu constraints to the map",
      new_path_length, counted(report.extension.sections.size(), "section").c_str(),
      report.key_frames, ties);
}

}  // namespace

std::vector<std::string> extension_lines(const ExtensionReport& report) {
  const std::string omitted = omitted_line(report.extension.omitted);
  std::vector<std::string> lines;
  if (report.is_written()) {
    lines.push_back(added_line(report));
  } else {
    lines.push_back(std::string(omitted.empty() ? "nothing of the drive is new to the map"
                                                : "nothing could be added to the map") +
                    ", so no session is written");
  }
  if (!omitted.empty()) lines.push_back(omitted);
  if (report.is_written()) {
    lines.push_back(
        formatted("the key frames of the map moved by %.3f m at most", report.largest_move));
  }
  return lines;
}

}  // namespace lidar_mapping::pipeline
