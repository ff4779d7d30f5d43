// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/extension_lines.hpp"

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::pipeline {

namespace {

/// m: a shorter way is not worth a word. Chosen: it would be shown as 0 m.
constexpr double kLeastShownWay = 0.5;

/// New ways that were not added and why; empty without any.
std::string left_out_line(const LeftOutWays& left_out) {
  std::vector<std::string> ways;
  const auto add = [&](double way, const std::string& reason) {
    if (way >= kLeastShownWay) ways.push_back(formatted("%.0f m %s", way, reason.c_str()));
  };
  add(left_out.never_found, "from which odometry leads to no place that was found in the map");
  add(left_out.too_short, formatted("in stretches of less than %g m", kLeastNewWay));
  add(left_out.not_tied,
      formatted("that less than %zu ties hold without contradiction", kLeastTies));
  return ways.empty() ? "" : "left out: " + joined(ways, "; ");
}

std::string added_line(const ExtensionReport& report) {
  double new_way = 0.0;
  std::size_t ties = 0;
  for (const NewStretch& stretch : report.extension.stretches) {
    new_way += stretch.new_way;
    ties += stretch.ties.size();
  }
  const std::size_t stretches = report.extension.stretches.size();
  return formatted(
      "new to the map: %.0f m in %zu %s; with what lies beside them %zu key frames, held by %zu "
      "ties",
      new_way, stretches, stretches == 1 ? "stretch" : "stretches", report.key_frames, ties);
}

}  // namespace

std::vector<std::string> extension_lines(const ExtensionReport& report) {
  const std::string left_out = left_out_line(report.extension.left_out);
  std::vector<std::string> lines;
  if (report.is_written()) {
    lines.push_back(added_line(report));
  } else {
    lines.push_back(std::string(left_out.empty() ? "nothing of the drive is new to the map"
                                                 : "nothing could be added to the map") +
                    ", so no session is written");
  }
  if (!left_out.empty()) lines.push_back(left_out);
  if (report.is_written()) {
    lines.push_back(
        formatted("the key frames of the map moved by %.3f m at most", report.largest_move));
  }
  return lines;
}

}  // namespace lidar_mapping::pipeline
