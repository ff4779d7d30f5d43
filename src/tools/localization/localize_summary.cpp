// SPDX-License-Identifier: BSD-3-Clause
#include "localization/localize_summary.hpp"

#include <algorithm>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/pipeline/extension_lines.hpp"

namespace lidar_mapping::tools {

namespace {

using json::Json;
using localization::LocalizationState;

constexpr double kMilliseconds = 1e3;  // in a second, by definition

std::size_t count_of(const std::vector<LocalizedScan>& scans, LocalizationState state) {
  return static_cast<std::size_t>(
      std::count_if(scans.begin(), scans.end(),
                    [&](const LocalizedScan& scan) { return scan.result.state == state; }));
}

/// Of the first scan with a pose; null if there is none.
Json found_after(const std::vector<LocalizedScan>& scans) {
  const auto found = std::find_if(scans.begin(), scans.end(), [](const LocalizedScan& scan) {
    return localization::has_pose(scan.result.state);
  });
  if (found == scans.end()) return nullptr;
  return {{"seconds", to_seconds(found->result.stamp - scans.front().result.stamp)},
          {"metres", found->path}};
}

/// Mean over the scans that were followed; 0 if there are none.
double mean_agreement(const std::vector<LocalizedScan>& scans) {
  double sum = 0.0;
  std::size_t followed = 0;
  for (const LocalizedScan& scan : scans) {
    if (scan.result.state != LocalizationState::kFollowing) continue;
    sum += scan.result.agreement;
    ++followed;
  }
  return followed == 0 ? 0.0 : sum / static_cast<double>(followed);
}

/// Of scans whose place was known before they came, or of those for which it was searched.
Json times_of(const std::vector<LocalizedScan>& scans, bool place_was_known) {
  std::vector<double> milliseconds;
  double sum = 0.0;
  bool is_known = false;
  for (const LocalizedScan& scan : scans) {
    if (is_known == place_was_known) {
      milliseconds.push_back(kMilliseconds * scan.seconds);
      sum += milliseconds.back();
    }
    is_known = localization::has_pose(scan.result.state);
  }
  if (milliseconds.empty()) return nullptr;
  return {{"mean", sum / static_cast<double>(milliseconds.size())},
          {"p99", quantile(milliseconds, 0.99)}};
}

std::string time_text(const char* name, const Json& times) {
  if (times.is_null()) return "";
  return formatted(" %s %.1f ms, at most %.1f ms for 99 %%;", name, times["mean"].get<double>(),
                   times["p99"].get<double>());
}

}  // namespace

Json localization_figures(const std::vector<LocalizedScan>& scans) {
  Json figures;
  figures["scans"] = scans.size();
  figures["path_m"] = scans.empty() ? 0.0 : scans.back().path;
  figures["found_after"] = found_after(scans);
  for (const LocalizationState state :
       {LocalizationState::kSearching, LocalizationState::kFollowing, LocalizationState::kBesideMap,
        LocalizationState::kLost}) {
    figures["states"][to_string(state)] = count_of(scans, state);
  }
  figures["mean_agreement"] = mean_agreement(scans);
  figures["milliseconds"] = {{"following", times_of(scans, true)},
                             {"searching", times_of(scans, false)}};
  return figures;
}

std::string localization_text(const Json& figures) {
  const auto scans = figures["scans"].get<double>();
  const auto percent = [&](const char* state) {
    return 100.0 * figures["states"][state].get<double>() / std::max(1.0, scans);
  };
  std::string text;
  const Json& found = figures["found_after"];
  if (!found.is_null()) {
    text = formatted("found after %.1f s and %.1f m\n", found["seconds"].get<double>(),
                     found["metres"].get<double>());
  }
  text += formatted(
      "%.0f scans over %.0f m: %.1f %% followed, %.1f %% outside the map, %.1f %% lost, %.1f %% "
      "searching; mean agreement %.2f\n",
      scans, figures["path_m"].get<double>(), percent("following"), percent("beside_map"),
      percent("lost"), percent("searching"), figures["mean_agreement"].get<double>());
  const Json& times = figures["milliseconds"];
  const std::string per_scan =
      time_text("following", times["following"]) + time_text("searching", times["searching"]);
  if (!per_scan.empty()) text += "processor time per scan:" + per_scan + "\n";
  return text;
}

std::string extension_text(const pipeline::ExtensionReport& report, const std::string& session) {
  std::string text;
  for (const std::string& line : pipeline::extension_lines(report)) text += line + "\n";
  return report.is_written() ? text + session + "\n" : text;
}

}  // namespace lidar_mapping::tools
