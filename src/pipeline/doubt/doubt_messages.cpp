// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"

namespace lidar_mapping::pipeline {

namespace {

/// Chosen: more sentences would not be read; the file holds all sections.
constexpr std::size_t kMaxWarnings = 2;

std::string warning_on(const DoubtfulSection& section, const DriveDoubt& drive) {
  const double begin = to_seconds(section.begin - drive.begin);
  const double end = to_seconds(section.end - drive.begin);
  if (section.doubt == Doubt::kLost) {
    return formatted(
        "Do not trust the relative pose of the parts of this map: at %.1f s (%.0f m of %.0f m of "
        "path) the odometry was lost, and no loop or GNSS connects the parts before and after",
        begin, section.path_begin, drive.path_length);
  }
  if (section.doubt != Doubt::kDegenerate) {
    return formatted(
        "Do not trust this map between %.1f s and %.1f s (%.0f m of %.0f m of path): %zu of its "
        "steps are %s, and no other constraint corrects them; expected error %.*f m",
        begin, end, section.path_length, drive.path_length, section.scans, to_string(section.doubt),
        section.expected_error < 3.0 ? 1 : 0, section.expected_error);
  }
  return formatted(
      "Do not trust this map between %.1f s and %.1f s (%.0f m of %.0f m of path): nothing "
      "observed the motion along the path; expected error %.*f m",
      begin, end, section.path_length, drive.path_length, section.expected_error < 3.0 ? 1 : 0,
      section.expected_error);
}

std::string section_counts(const DriveDoubt& drive, Doubt doubt) {
  std::size_t scans = 0;
  std::size_t section_count = 0;
  for (const DoubtfulSection& section : drive.sections) {
    if (section.doubt != doubt || !section.is_trusted) continue;
    scans += section.scans;
    ++section_count;
  }
  if (section_count == 0) return {};
  return counted(scans, "scan") + ' ' + to_string(doubt) + " in " + counted(section_count, "place");
}

}  // namespace

std::vector<std::string> warnings(const DriveDoubt& doubt) {
  std::vector<DoubtfulSection> worst;
  for (const DoubtfulSection& section : doubt.sections) {
    if (!section.is_trusted) worst.push_back(section);
  }
  std::stable_sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) {
    return a.expected_error > b.expected_error;
  });
  std::vector<std::string> messages;
  for (const DoubtfulSection& section : worst) {
    if (messages.size() == kMaxWarnings) break;
    messages.push_back(warning_on(section, doubt));
  }
  if (worst.size() > kMaxWarnings) {
    messages.push_back(
        formatted("There are %zu more such sections in doubt.csv", worst.size() - kMaxWarnings));
  }
  return messages;
}

std::string remark(const DriveDoubt& doubt) {
  std::vector<std::string> found;
  for (const Doubt kind :
       {Doubt::kLost, Doubt::kRepeated, Doubt::kDegraded, Doubt::kDoubtful, Doubt::kDegenerate}) {
    const std::string part = section_counts(doubt, kind);
    if (!part.empty()) found.push_back(part);
  }
  return found.empty() ? "" : "Noticed: " + joined(found) + " (doubt.csv)";
}

}  // namespace lidar_mapping::pipeline
