// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"

#include "report_figures.hpp"

namespace lidar_mapping::report {

namespace {

/// The key frames around a section, as positions in `poses`; null if its drive has none.
json::Json rows_of(const pipeline::DoubtfulSection& section,
                   const std::vector<KeyFramePose>& poses) {
  if (!section.key_frames) return nullptr;
  const auto row = [&](KeyFrameIndex index) { return find_index(poses, index) - poses.begin(); };
  return {row(section.key_frames->first), row(section.key_frames->last)};
}

}  // namespace

json::Json doubt_figures(const ReportInput& input, const back_end::BackEnd& back_end) {
  const pipeline::DriveDoubt doubt = pipeline::drive_doubt(input.session, back_end, input.poses);
  json::Json rows = json::Json::array();
  for (const pipeline::DoubtfulSection& section : doubt.sections) {
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
         {"rows", rows_of(section, input.poses.poses)}});
  }
  return {{"sections", rows}, {"warnings", pipeline::warnings(doubt)}};
}

}  // namespace lidar_mapping::report
