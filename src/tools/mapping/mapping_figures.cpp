// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapping_figures.hpp"

#include "lidar_mapping/common/text.hpp"

#include "command_line/process_memory.hpp"

namespace lidar_mapping::tools {

namespace {

/// Numbers of data that were left out, by cause.
json::Json left_out(const pipeline::PipelineReport& report) {
  const preprocessing::PreprocessingCounters& counters = report.counters;
  return {{"scans damaged", report.scans_unreadable},
          {"scans without transform to base_link", counters.scans_without_extrinsic},
          {"scans with too few points", counters.scans_without_points},
          {"scans out of order", counters.scans_out_of_order + report.scans_before_newest},
          {"scans waiting when time went back", counters.scans_discarded},
          {"samples of IMU or velocity", counters.samples_refused},
          {"GNSS fixes", counters.gnss_refused}};
}

/// One line that names what was left out; empty if nothing was.
std::string left_out_text(const json::Json& numbers) {
  std::string text;
  for (const auto& [cause, number] : numbers.items()) {
    if (number == 0) continue;
    text += (text.empty() ? "left out: " : ", ") + number.dump() + " " + cause;
  }
  return text.empty() ? "" : text + "\n";
}

}  // namespace

json::Json mapping_figures(const pipeline::PipelineReport& report, double driven,
                           const RunTimes& times) {
  json::Json json;
  json["driven_seconds"] = driven;
  json["scans"] = report.progress.scans;
  json["key_frames"] = report.optimization.key_frames;
  json["loops_used"] = report.optimization.loops_used;
  json["left_out"] = left_out(report);
  json["seconds"] = {{"mapping", times.mapped},
                     {"of it reading and odometry", times.streamed},
                     {"map", times.map},
                     {"whole", times.whole}};
  json["times_real_time"] = {{"mapping", driven / times.mapped}, {"whole", driven / times.whole}};
  json["peak_megabytes"] = static_cast<double>(peak_bytes()) * 1e-6;
  auto& stages = json["processor_seconds"];
  stages["reading"] = times.reading;
  for (const auto& [name, seconds] : report.stage_seconds) stages[name] = seconds;
  return json;
}

std::string to_text(const json::Json& figures) {
  const auto& speed = figures["times_real_time"];
  std::string text =
      formatted("%zu scans, %zu key frames, %zu loops; peak memory %.0f MB\n",
                figures["scans"].get<std::size_t>(), figures["key_frames"].get<std::size_t>(),
                figures["loops_used"].get<std::size_t>(), figures["peak_megabytes"].get<double>());
  text += left_out_text(figures["left_out"]) + "processor seconds:";
  for (const auto& [name, seconds] : figures["processor_seconds"].items()) {
    text += formatted(" %s %.1f;", name.c_str(), seconds.get<double>());
  }
  return text +
         formatted(
             "\n%.0f s of driving mapped in %.1f s (%.1f times real time), with the map %.1f s "
             "(%.1f times)\n",
             figures["driven_seconds"].get<double>(), figures["seconds"]["mapping"].get<double>(),
             speed["mapping"].get<double>(), figures["seconds"]["whole"].get<double>(),
             speed["whole"].get<double>());
}

}  // namespace lidar_mapping::tools
