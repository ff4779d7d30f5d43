// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "lidar_mapping/pipeline/drive_doubt.hpp"

#include "report_figures.hpp"

namespace lidar_mapping::report {

namespace {

/// The key frames between which a stretch lies, as positions in `poses`.
std::pair<std::size_t, std::size_t> around(const pipeline::DoubtfulSection& stretch,
                                           const std::vector<KeyFramePose>& poses) {
  std::size_t first = 0;
  std::size_t last = poses.empty() ? 0 : poses.size() - 1;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].stamp <= stretch.begin) first = i;
    if (poses[i].stamp >= stretch.end) last = std::min(last, i);
  }
  return {first, last};
}

}  // namespace

json::Json doubt_figures(const ReportInput& input, const back_end::BackEnd& back_end) {
  const pipeline::DriveDoubt doubt = pipeline::drive_doubt(input.session, back_end, input.poses);
  json::Json rows = json::Json::array();
  for (const pipeline::DoubtfulSection& stretch : doubt.sections) {
    const auto [first, last] = around(stretch, input.poses.poses);
    rows.push_back(
        {{"kind", to_string(stretch.doubt)},
         {"begin_s", to_seconds(stretch.begin - doubt.begin)},
         {"end_s", to_seconds(stretch.end - doubt.begin)},
         {"scans", stretch.scans},
         {"way_m", stretch.path_length},
         {"error_m", std::isfinite(stretch.expected_error) ? json::Json(stretch.expected_error)
                                                           : json::Json()},
         {"lowest_probability", stretch.lowest_probability},
         {"trusted", stretch.is_trusted},
         {"rows", {first, last}}});
  }
  return {{"stretches", rows}, {"warnings", pipeline::warnings(doubt)}};
}

}  // namespace lidar_mapping::report
