// SPDX-License-Identifier: BSD-3-Clause
#include "examination_words.hpp"

#include <algorithm>

#include "lidar_mapping/common/text.hpp"

#include "report_examination.hpp"

namespace lidar_mapping::report {

namespace {

using json::Json;

/// Words for the states in the order in which they are shown.
constexpr const char* kStates[][2] = {{"following", "followed"},
                                      {"beside_map", "outside the map"},
                                      {"lost", "lost"},
                                      {"searching", "searched"}};

std::string position_words(const Json& part) {
  return formatted("at %.1f, %.1f", part["x"].get<double>(), part["y"].get<double>());
}

std::string head(const Json& figures) {
  const auto recordings = figures["recordings"].get<std::vector<std::string>>();
  const Json& found = figures["found_after"];
  return "examined by " + figures["name"].get<std::string>() + " (" + joined(recordings) +
         formatted("), %zu scans over %.0f m: ", figures["scans"].get<std::size_t>(),
                   figures["path_m"].get<double>()) +
         (found.is_null()
              ? "never found in the map\n"
              : formatted("found after %.1f s and %.1f m\n", found["seconds"].get<double>(),
                          found["metres"].get<double>()));
}

std::string state_lines(const Json& states) {
  std::string text;
  for (const auto& [state, words] : kStates) {
    text +=
        formatted("  %-15s %7zu scans %9.1f m\n", words, states[state]["scans"].get<std::size_t>(),
                  states[state]["path_m"].get<double>());
  }
  return text;
}

std::string agreement_line(const Json& figures) {
  if (figures["agreement"].is_null()) return "";
  std::vector<std::string> parts;
  for (const char* name : {"agreement", "coverage"}) {
    parts.push_back(formatted("%s %.2f, a tenth of the scans below %.2f", name,
                              figures[name]["mean"].get<double>(),
                              figures[name]["lowest_tenth"].get<double>()));
  }
  return "  " + joined(parts, "; ") + "\n";
}

std::string odometry_lines(const Json& odometry) {
  if (odometry["largest"].is_null()) return "";
  std::string text =
      formatted("  motion over %.0f m against odometry: mean %.3f m, rms %.3f m, largest %.3f m (",
                odometry["delta_m"].get<double>(), odometry["mean_m"].get<double>(),
                odometry["rmse_m"].get<double>(), odometry["max_m"].get<double>());
  text += place_words(odometry["largest"]) + ")\n";
  for (const Json& jump : odometry["jumps"]) {
    text +=
        formatted("  jump of %.2f m and %.1f deg before %.1f s, ", jump["error_m"].get<double>(),
                  jump["error_deg"].get<double>(), jump["end_s"].get<double>()) +
        place_words(jump) + "\n";
  }
  return text;
}

std::string loss_lines(const Json& losses) {
  std::string text;
  for (const Json& loss : losses) {
    text += formatted("  lost after %.1f s for %zu scans and %.1f m, %s, ",
                      loss["begin_s"].get<double>(), loss["scans"].get<std::size_t>(),
                      loss["path_m"].get<double>(),
                      loss["in_map"].get<bool>() ? "in the map" : "outside the map") +
            place_words(loss) + ": " + loss["reason"].get<std::string>() + "\n";
  }
  return text;
}

std::string section_lines(const Json& figures, std::size_t most) {
  const std::vector<Json> passed = passed_sections(figures);
  std::string text =
      formatted("  %zu of %zu sections of %.0f m of the map were passed", passed.size(),
                figures["sections"].size(), figures["section_m"].get<double>());
  const std::size_t shown = std::min(most, passed.size());
  if (shown == 0) return text + "\n";
  text += "; least agreement first:\n";
  text += "    key frames              x        y  passes  scans  followed  agreement  coverage\n";
  for (std::size_t i = 0; i < shown; ++i) {
    const Json& section = passed[i];
    const auto count = [&](const char* name) { return section[name].get<std::size_t>(); };
    const auto number = [&](const char* name) { return section[name].get<double>(); };
    const std::string key_frames =
        formatted("%zu to %zu", count("first_key_frame"), count("last_key_frame"));
    text += formatted("    %-16s %8.1f %8.1f  %6zu  %5zu  %8zu  %9.2f  %8.2f\n", key_frames.c_str(),
                      number("x"), number("y"), count("passes"), count("scans"), count("followed"),
                      number("agreement"), number("coverage"));
  }
  return text;
}

}  // namespace

std::string place_words(const Json& part) {
  if (part["x"].is_null()) return "at an unknown place";
  if (part["key_frame"].is_null()) return position_words(part);
  return formatted("key frame %zu ", part["key_frame"].get<std::size_t>()) + position_words(part);
}

std::vector<Json> passed_sections(const Json& figures) {
  std::vector<Json> passed;
  for (const Json& section : figures["sections"]) {
    if (!section["agreement"].is_null()) passed.push_back(section);
  }
  std::stable_sort(passed.begin(), passed.end(), [](const Json& a, const Json& b) {
    return a["agreement"].get<double>() < b["agreement"].get<double>();
  });
  return passed;
}

std::string section_words(const Json& section) {
  return formatted("key frames %zu to %zu ", section["first_key_frame"].get<std::size_t>(),
                   section["last_key_frame"].get<std::size_t>()) +
         position_words(section);
}

std::string examination_text(const Json& figures, std::size_t sections) {
  return head(figures) + state_lines(figures["states"]) + agreement_line(figures) +
         odometry_lines(figures["odometry"]) + loss_lines(figures["losses"]) +
         section_lines(figures, sections);
}

}  // namespace lidar_mapping::report
