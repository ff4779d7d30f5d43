// SPDX-License-Identifier: BSD-3-Clause
#include "localization/localize_summary.hpp"

#include <algorithm>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/text.hpp"

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

/// m: a shorter way is not worth a word. Chosen: it would be shown as 0 m.
constexpr double kLeastShownWay = 0.5;

/// New ways that were not added and why; empty without any.
std::string left_out_text(const pipeline::LeftOutWays& left_out) {
  std::vector<std::string> ways;
  const auto add = [&](double way, const std::string& reason) {
    if (way >= kLeastShownWay) ways.push_back(formatted("%.0f m %s", way, reason.c_str()));
  };
  add(left_out.never_found, "from which odometry leads to no place that was found in the map");
  add(left_out.too_short, formatted("in stretches of less than %g m", pipeline::kLeastNewWay));
  add(left_out.not_tied,
      formatted("that less than %zu ties hold without contradiction", pipeline::kLeastTies));
  return ways.empty() ? "" : "left out: " + joined(ways, "; ") + "\n";
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
      "%.0f scans over %.0f m: %.1f %% followed, %.1f %% beside the map, %.1f %% lost, %.1f %% "
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
  const std::string left_out = left_out_text(report.extension.left_out);
  if (!report.is_written()) {
    return std::string(left_out.empty() ? "nothing of the drive is new to the map"
                                        : "nothing could be added to the map") +
           ", so no session is written\n" + left_out;
  }
  double new_way = 0.0;
  std::size_t ties = 0;
  for (const pipeline::NewStretch& stretch : report.extension.stretches) {
    new_way += stretch.new_way;
    ties += stretch.ties.size();
  }
  const std::size_t stretches = report.extension.stretches.size();
  return formatted(
             "new to the map: %.0f m in %zu %s; with what lies beside them %zu key frames, held by "
             "%zu ties\n",
             new_way, stretches, stretches == 1 ? "stretch" : "stretches", report.key_frames,
             ties) +
         left_out +
         formatted("the key frames of the map moved by %.3f m at most\n", report.largest_move) +
         session + "\n";
}

}  // namespace lidar_mapping::tools
