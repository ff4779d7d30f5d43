// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "lidar_mapping/pipeline/drive_doubt.hpp"

#include "report_figures.hpp"

namespace lidar_mapping::report {

namespace {

/// The key frames around a section, as positions in `poses`.
std::pair<std::size_t, std::size_t> around(const pipeline::DoubtfulSection& section,
                                           const std::vector<KeyFramePose>& poses) {
  std::size_t first = 0;
  std::size_t last = poses.empty() ? 0 : poses.size() - 1;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].stamp <= section.begin) first = i;
    if (poses[i].stamp >= section.end) last = std::min(last, i);
  }
  return {first, last};
}

}  // namespace

json::Json doubt_figures(const ReportInput& input, const back_end::BackEnd& back_end) {
  const pipeline::DriveDoubt doubt = pipeline::drive_doubt(input.session, back_end, input.poses);
  json::Json rows = json::Json::array();
  for (const pipeline::DoubtfulSection& section : doubt.sections) {
    const auto [first, last] = around(section, input.poses.poses);
    rows.push_back(
        {{"kind", to_string(section.doubt)},
         {"begin_s", to_seconds(section.begin - doubt.begin)},
         {"end_s", to_seconds(section.end - doubt.begin)},
         {"scans", section.scans},
         {"path_length_m", section.path_length},
         {"error_m", std::isfinite(section.expected_error) ? json::Json(section.expected_error)
                                                           : json::Json()},
         {"lowest_probability", section.lowest_probability.value_or(pipeline::kUnknownProbability)},
         {"trusted", section.is_trusted},
         {"rows", {first, last}}});
  }
  return {{"sections", rows}, {"warnings", pipeline::warnings(doubt)}};
}

}  // namespace lidar_mapping::report
