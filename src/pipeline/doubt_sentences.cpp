// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>

#include "lidar_mapping/pipeline/drive_doubt.hpp"

namespace lidar_mapping::pipeline {

namespace {

/// More sentences nobody reads; the file has all.
constexpr std::size_t kSentences = 2;

template <typename... Values>
std::string text(const char* format, Values... values) {
  std::array<char, 320> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  return buffer.data();
}

std::string sentence_on(const DoubtfulStretch& stretch, const DriveDoubt& drive) {
  const double begin = to_seconds(stretch.begin - drive.begin);
  const double end = to_seconds(stretch.end - drive.begin);
  if (stretch.doubt == Doubt::kLost) {
    return text(
        "Do not trust how the parts of this map lie to each other: at %.1f s (%.0f m of %.0f m of "
        "way) the odometry was lost, and no loop or GNSS joins what came before and after",
        begin, stretch.way_begin, drive.way);
  }
  if (stretch.doubt != Doubt::kDegenerate) {
    return text(
        "Do not trust this map between %.1f s and %.1f s (%.0f m of %.0f m of way): %zu of its "
        "steps "
        "are %s, and nothing else holds it there; expected error %.*f m",
        begin, end, stretch.way, drive.way, stretch.scans, to_string(stretch.doubt),
        stretch.expected_error < 3.0 ? 1 : 0, stretch.expected_error);
  }
  return text(
      "Do not trust this map between %.1f s and %.1f s (%.0f m of %.0f m of way): nothing observed "
      "the motion along the way; expected error %.*f m",
      begin, end, stretch.way, drive.way, stretch.expected_error < 3.0 ? 1 : 0,
      stretch.expected_error);
}

std::string counted(const DriveDoubt& drive, Doubt doubt) {
  std::size_t scans = 0;
  std::size_t places = 0;
  for (const DoubtfulStretch& stretch : drive.stretches) {
    if (stretch.doubt != doubt || !stretch.is_trusted) continue;
    scans += stretch.scans;
    ++places;
  }
  if (places == 0) return {};
  return text("%zu %s %s in %zu %s", scans, scans == 1 ? "scan" : "scans", to_string(doubt), places,
              places == 1 ? "place" : "places");
}

}  // namespace

std::vector<std::string> warnings(const DriveDoubt& doubt) {
  std::vector<DoubtfulStretch> worst;
  for (const DoubtfulStretch& stretch : doubt.stretches) {
    if (!stretch.is_trusted) worst.push_back(stretch);
  }
  std::stable_sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) {
    return a.expected_error > b.expected_error;
  });
  std::vector<std::string> sentences;
  for (const DoubtfulStretch& stretch : worst) {
    if (sentences.size() == kSentences) break;
    sentences.push_back(sentence_on(stretch, doubt));
  }
  if (worst.size() > kSentences) {
    sentences.push_back(
        text("There are %zu more such stretches in doubt.csv", worst.size() - kSentences));
  }
  return sentences;
}

std::string remark(const DriveDoubt& doubt) {
  std::string found;
  for (const Doubt kind :
       {Doubt::kLost, Doubt::kRepeated, Doubt::kDegraded, Doubt::kDoubtful, Doubt::kDegenerate}) {
    const std::string part = counted(doubt, kind);
    if (!part.empty()) found += (found.empty() ? "" : ", ") + part;
  }
  return found.empty() ? found : "Noticed: " + found + " (doubt.csv)";
}

}  // namespace lidar_mapping::pipeline
