// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/evaluation/association.hpp"
#include "lidar_mapping/pipeline/tracking_summary.hpp"

#include "report_examination.hpp"
#include "report_figures.hpp"

namespace lidar_mapping::report {

namespace {

// Limits beyond which a user should check the map. Chosen: ratios above those of good simulated
// maps (1.2 to the noise), misalignments about twice what these have (3 cm, 10 cm along, 0.1
// degrees), the others so that what is visible in a map, or wrong in the inputs, is named.
constexpr double kMaxRatio = 1.5;               // thickness to what the noise gives
constexpr double kMaxPoseRatio = 1.3;           // thickness to that of single groups
constexpr double kMaxMisalignmentAside = 0.05;  // m, left and up
constexpr double kMaxMisalignmentAlong = 0.2;   // m
constexpr double kMaxMisalignmentYaw = 0.2;     // deg
constexpr double kMaxLoopResidual = 0.15;       // m
constexpr double kMaxSigma = 0.5;               // m
constexpr double kMaxGnssSigmas = 4.0;          // 95 % of the residuals, against the stated sigma
constexpr double kMinGnssResidual = 0.1;        // m, never called too much

/// A row of the report; `limit` describes good values.
json::Json line(const char* name, const std::string& value, const json::Json& good,
                const std::string& note, const std::string& limit = "") {
  return {{"name", name}, {"value", value}, {"good", good}, {"note", note}, {"limit", limit}};
}

json::Json thickness_line(const char* name, const json::Json& thickness) {
  if (thickness["cells"] == 0) return line(name, "no planar cells", nullptr, "");
  const double median = thickness["median_m"];
  const double within = thickness["median_within_m"];
  const double from_poses = median / std::max(within, 1e-6);
  const json::Json& ratio = thickness["median_ratio_to_noise"];
  const bool good = from_poses < kMaxPoseRatio && (ratio.is_null() || ratio < kMaxRatio);
  const std::string value = formatted("%.1f mm", 1000.0 * median);
  const std::string own =
      formatted("single passes of a few metres alone: %.1f mm", 1000.0 * within);
  const std::string ratio_limit =
      formatted("below %.1f times that of single passes", kMaxPoseRatio);
  if (ratio.is_null()) return line(name, value, good, own, ratio_limit);
  return line(name, value + formatted(", %.2f of the noise", ratio.get<double>()), good, own,
              formatted("below %.1f of the noise and ", kMaxRatio) + ratio_limit);
}

bool is_beyond_limits(const json::Json& misalignment) {
  const auto exceeds = [&](const char* part, double limit) {
    return std::abs(misalignment[part].get<double>()) > limit;
  };
  return exceeds("left_m", kMaxMisalignmentAside) || exceeds("up_m", kMaxMisalignmentAside) ||
         exceeds("along_m", kMaxMisalignmentAlong) || exceeds("yaw_deg", kMaxMisalignmentYaw);
}

json::Json misalignment_line(const json::Json& misalignments) {
  const char* name = "Repeated passes";
  if (misalignments.empty()) {
    return line(name, "no place was driven twice", nullptr, "only local quality could be judged");
  }
  std::size_t beyond = 0;
  for (const json::Json& one : misalignments) beyond += is_beyond_limits(one) ? 1 : 0;
  const double worst = misalignments.front()["size_m"];
  const double median = misalignments[misalignments.size() / 2]["size_m"];
  return line(name, formatted("%.0f mm apart, worst %.0f mm", 1000.0 * median, 1000.0 * worst),
              beyond == 0,
              formatted("%zu places, %zu of them beyond the limits", misalignments.size(), beyond),
              formatted("below %.0f mm aside and up, %.0f mm along, %.1f deg",
                        1000.0 * kMaxMisalignmentAside, 1000.0 * kMaxMisalignmentAlong,
                        kMaxMisalignmentYaw));
}

json::Json loop_line(const json::Json& loops) {
  const std::size_t used = loops["used"];
  const std::size_t dropped = loops["dropped_by_graph"];
  const std::size_t refused = loops["refused_or_undecided"];
  const double worst = loops["max_residual_m"];
  const std::string note =
      formatted("%zu dropped by the graph, %zu refused or undecided", dropped, refused);
  if (used + dropped == 0) return line("Loops", "none", nullptr, note);
  return line("Loops", formatted("%zu used, residual up to %.0f mm", used, 1000.0 * worst),
              dropped == 0 && worst < kMaxLoopResidual, note,
              formatted("none dropped, residuals below %.0f mm", 1000.0 * kMaxLoopResidual));
}

json::Json gnss_line(const json::Json& gnss) {
  if (gnss["positions"] == 0) return line("GNSS", "none", nullptr, "the map is not georeferenced");
  const double residual = gnss["p95_horizontal_m"];
  const double stated = gnss["median_stated_sigma_m"];
  const double limit = std::max(kMinGnssResidual, kMaxGnssSigmas * stated);
  return line(
      "GNSS",
      formatted("%.0f mm horizontally in the median, 95 %% below %.0f mm",
                1000.0 * gnss["median_horizontal_m"].get<double>(), 1000.0 * residual),
      residual < limit,
      formatted("stated standard deviation %.0f mm; %s", 1000.0 * stated,
                gnss["used_by_graph"] ? "used by the graph" : "not used, aligned to the map"),
      formatted("95 %% below %.0f mm", 1000.0 * limit));
}

json::Json odometry_line(const json::Json& report) {
  const double farthest = report["trajectory"]["odometry_max_m"];
  const double vertical = report["trajectory"]["odometry_max_vertical_m"];
  const double length = report["drive"]["length_m"];
  const double limit = pipeline::allowed_error(length);
  const char* name = "Odometry against the map";
  const bool has_gnss = report["gnss"]["positions"] > 0 && report["gnss"]["used_by_graph"];
  if (report["loops"]["used"] == 0 && !has_gnss) {
    return line(name, "not known", nullptr,
                "the map is the odometry: no loop and no GNSS position corrected it");
  }
  return line(name, formatted("up to %.2f m apart", farthest), farthest < limit,
              formatted("up to %.2f m in height, over %.0f m", vertical, length),
              formatted("below %.1f m on a path of this length", limit));
}

json::Json scan_line(const json::Json& scans) {
  const std::size_t all = scans["scans"];
  const std::size_t dropped = scans["dropped"];
  const std::size_t tracked = scans["states"].value("tracking", std::size_t{0});
  if (all == 0) return line("Scans", "none recorded", nullptr, "the map was not made of a drive");
  return line("Scans", formatted("%zu, %zu of them tracked", all, tracked),
              dropped == 0 && tracked == all, formatted("%zu dropped", dropped),
              "all tracked, none dropped");
}

/// Name and position of a key frame in words.
std::string place(const json::Json& of) {
  return formatted("key frame %u at %.1f, %.1f", of["key_frame"].get<unsigned>(),
                   of["x"].get<double>(), of["y"].get<double>());
}

json::Json uncertainty_line(const json::Json& uncertainty) {
  const char* name = "Pose uncertainty";
  const json::Json& gap = uncertainty["longest_without_constraint"];
  const std::string note = formatted("longest path without loop or GNSS: %.0f m, from %.0f m on",
                                     gap["length_m"].get<double>(), gap["begin_m"].get<double>());
  const std::string limit = formatted(
      "below %.1f m, all connected and none doubtful; loops or GNSS on that path make it smaller",
      kMaxSigma);
  const json::Json& first = uncertainty["largest"];
  const json::Json& step = uncertainty["largest_step"];
  if (first.is_null() || step.is_null()) return line(name, "not known", nullptr, note);
  const double sigma = first["sigma_m"];
  std::string value = formatted("standard deviation up to %.2f m from the first key frame (%s), ",
                                sigma, place(first).c_str()) +
                      formatted("up to %.2f m from a neighbour (%s)", step["sigma_m"].get<double>(),
                                place(step).c_str());
  const std::size_t not_tied = uncertainty["not_tied"];
  const std::size_t doubtful = uncertainty["doubtful"];
  if (not_tied > 0) value += formatted("; %zu key frames are not connected to the first", not_tied);
  if (doubtful > 0) value += formatted("; %zu are doubtful", doubtful);
  return line(name, value, sigma < kMaxSigma && not_tied == 0 && doubtful == 0, note, limit);
}

/// The worst section that cannot be trusted.
json::Json doubt_line(const json::Json& doubt) {
  const char* name = "Motion observed";
  const std::string limit =
      "parts of the map connected, and errors of the unobserved path below 1 % of its length";
  const json::Json* worst = nullptr;
  std::size_t untrusted = 0;
  for (const json::Json& section : doubt["sections"]) {
    if (section["trusted"]) continue;
    ++untrusted;
    // Null is an unknown error, which counts as larger than any other.
    const auto is_worse = [](const json::Json& a, const json::Json& b) {
      return !b.is_null() && (a.is_null() || a.get<double>() > b.get<double>());
    };
    if (worst == nullptr || is_worse(section["error_m"], (*worst)["error_m"])) worst = &section;
  }
  if (worst == nullptr) {
    return line(name, "all along", true,
                formatted("%zu remarks in doubt.csv", doubt["sections"].size()), limit);
  }
  const json::Json& error = (*worst)["error_m"];
  const std::string value =
      error.is_null()
          ? formatted("lost at %.1f s, parts not connected", (*worst)["begin_s"].get<double>())
          : formatted("not between %.1f and %.1f s, error %.1f m",
                      (*worst)["begin_s"].get<double>(), (*worst)["end_s"].get<double>(),
                      error.get<double>());
  return line(name, value, false, formatted("%zu sections cannot be trusted", untrusted), limit);
}

json::Json truth_line(const json::Json& truth) {
  const double delta = truth["rpe_delta_m"];
  std::string note = "after rigid alignment; ";
  note += truth["rpe_count"] == 0 ? formatted("no RPE: the path is shorter than %.0f m", delta)
                                  : formatted("RPE over %.0f m %.1f mm, %.3f deg", delta,
                                              1000.0 * truth["rpe_rmse_m"].get<double>(),
                                              truth["rpe_rmse_deg"].get<double>());
  const evaluation::LeftOut left_out{truth["left_out"]["outside"], truth["left_out"]["in_gaps"]};
  const std::string reason = evaluation::reason_of(left_out, "the truth");
  if (!reason.empty()) note += "; of the key frames " + reason;
  return line("Against the truth",
              formatted("APE %.0f mm, at most %.0f mm", 1000.0 * truth["ape_rmse_m"].get<double>(),
                        1000.0 * truth["ape_max_m"].get<double>()),
              nullptr, note);
}

}  // namespace

json::Json verdicts(const json::Json& report) {
  json::Json lines = {thickness_line("Walls", report["thickness"]["walls"]),
                      thickness_line("Ground", report["thickness"]["ground"]),
                      misalignment_line(report["misalignments"]),
                      loop_line(report["loops"]),
                      gnss_line(report["gnss"]),
                      odometry_line(report),
                      scan_line(report["scans"]),
                      uncertainty_line(report["uncertainty"]),
                      doubt_line(report["doubt"])};
  for (const json::Json& drive : report["examinations"]) {
    lines.push_back(examination_verdict(drive));
  }
  if (!report["truth"].is_null()) lines.push_back(truth_line(report["truth"]));
  return lines;
}

std::string overall_verdict(const json::Json& report) {
  if (report["drive"]["key_frames"] == 0) return "There is no map: the session has no key frames";
  std::vector<std::string> faults;
  for (const json::Json& line : report["verdicts"]) {
    if (line["good"] != false) continue;
    faults.push_back(line["name"].get<std::string>());
  }
  std::string text =
      faults.empty() ? "Good: nothing that has to be checked" : "Look at: " + joined(faults);
  if (report["misalignments"].empty()) {
    text += "; no place was driven twice, so only local quality could be judged";
  }
  return text;
}

}  // namespace lidar_mapping::report
