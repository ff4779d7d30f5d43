// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "lidar_mapping/common/text.hpp"

#include "examination_words.hpp"
#include "report_examination.hpp"

namespace lidar_mapping::report {

namespace {

using json::Json;

/// Fraction of the path in the map that has to be followed. Chosen: simulated drives of other days
/// were followed all along once they were found (doc/results/localization.md); beside real roads
/// lorries hide the map now and then.
constexpr double kLeastFollowed = 0.95;
/// Mean agreement of a section. Chosen: as kAgreeing in hypothesis.cpp, with less than
/// which no place is followed.
constexpr double kLeastAgreement = 0.25;
/// m: path in the map that an examination needs. Chosen: one section says nothing about a map.
constexpr double kLeastPath = 20.0;

std::string limit_words(const Json& figures) {
  return formatted("found, %.0f %% of the path in the map followed, never lost there, no jump, ",
                   100.0 * kLeastFollowed) +
         formatted("agreement of each section of %.0f m above %.2f",
                   figures["section_m"].get<double>(), kLeastAgreement);
}

void add_losses(const Json& losses, std::vector<std::string>& faults) {
  std::vector<std::string> places;
  for (const Json& loss : losses) {
    if (loss["in_map"].get<bool>()) places.push_back(place_words(loss));
  }
  if (places.empty()) return;
  faults.push_back("lost " + counted(places.size(), "time") + " in it (first " + places.front() +
                   ")");
}

void add_jumps(const Json& jumps, std::vector<std::string>& faults) {
  if (jumps.empty()) return;
  const auto largest =
      std::max_element(jumps.begin(), jumps.end(), [](const Json& a, const Json& b) {
        return a["error_m"].get<double>() < b["error_m"].get<double>();
      });
  faults.push_back(counted(jumps.size(), "jump") +
                   formatted(" (largest %.2f m, ", (*largest)["error_m"].get<double>()) +
                   place_words(*largest) + ")");
}

void add_weak_sections(const Json& figures, std::vector<std::string>& faults) {
  const std::vector<Json> passed = passed_sections(figures);
  const auto weak = std::count_if(passed.begin(), passed.end(), [](const Json& section) {
    return section["agreement"].get<double>() < kLeastAgreement;
  });
  if (weak == 0) return;
  faults.push_back(counted(static_cast<std::size_t>(weak), "weak section") + " (worst " +
                   section_words(passed.front()) + ")");
}

/// What speaks against the map beside the path that was not followed.
std::vector<std::string> faults_of(const Json& figures) {
  std::vector<std::string> faults;
  add_losses(figures["losses"], faults);
  add_jumps(figures["odometry"]["jumps"], faults);
  add_weak_sections(figures, faults);
  return faults;
}

std::string note_words(const Json& figures) {
  const Json& found = figures["found_after"];
  std::string note = formatted("found after %.1f s and %.1f m", found["seconds"].get<double>(),
                               found["metres"].get<double>());
  const Json& agreement = figures["agreement"];
  if (!agreement.is_null()) {
    note += formatted("; agreement %.2f, a tenth of the scans below %.2f",
                      agreement["mean"].get<double>(), agreement["lowest_tenth"].get<double>());
  }
  const Json& odometry = figures["odometry"];
  if (odometry["largest"].is_null()) return note;
  return note + formatted("; motion over %.0f m up to %.2f m from odometry",
                          odometry["delta_m"].get<double>(), odometry["max_m"].get<double>());
}

}  // namespace

Json examination_verdict(const Json& figures) {
  Json line = {{"name", "Examination by " + figures["name"].get<std::string>()},
               {"value", "never found in the map"},
               {"good", false},
               {"note", formatted("searched over %.0f m", figures["path_m"].get<double>())},
               {"limit", limit_words(figures)}};
  if (figures["found_after"].is_null()) return line;
  const double path = figures["in_map"]["path_m"];
  const double followed = figures["in_map"]["followed"]["path_m"];
  std::vector<std::string> words = faults_of(figures);
  const bool is_good = words.empty() && followed >= kLeastFollowed * path;
  const bool is_short = is_good && path < kLeastPath;
  words.insert(words.begin(), formatted("%.1f %% of %.1f m in the map followed",
                                        path > 0.0 ? 100.0 * followed / path : 100.0, path));
  if (is_short) words.emplace_back("too short to judge the map by");
  line["value"] = joined(words, "; ");
  line["good"] = is_short ? Json() : Json(is_good);
  line["note"] = note_words(figures);
  return line;
}

}  // namespace lidar_mapping::report
