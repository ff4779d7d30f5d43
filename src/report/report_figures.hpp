// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/back_end/key_frame_deviation.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"
#include "lidar_mapping/session/session.hpp"

#include "json.hpp"

namespace lidar_mapping::report {

/// A session's map, as the figures need it.
struct ReportInput {
  const session::Session& session;
  KeyFramePoses poses;     ///< newest, T_map_base
  KeyFramePoses odometry;  ///< laid so that the first key frame is where it is in `poses`
  std::optional<Trajectory> truth;
};

/// Optimised poses, with odometry behind the last of them.
ReportInput report_input(const session::Session& session, std::optional<Trajectory> truth = {});
/// Whether the graph put the map into East-North-Up.
bool is_in_enu(const session::Session& session);
/// The session's graph, solved again.
std::unique_ptr<back_end::BackEnd> solved_graph(const session::Session& session);

// Parts of report.json; lengths in m, angles in deg.
/// Recording, sensors, software, command and coordinates; null for what is not known.
json::Json origin_figures(const ReportInput& input);
/// Files of the session and its map, with their sizes, and the map's extent where there is one.
json::Json product_figures(const ReportInput& input);
json::Json drive_figures(const ReportInput& input);
/// Path length, position and distance from odometry of every key frame.
json::Json trajectory_figures(const ReportInput& input);
/// What loops and GNSS say against the newest poses.
json::Json loop_figures(const ReportInput& input);
json::Json gnss_figures(const ReportInput& input, const back_end::BackEnd& back_end);
json::Json scan_figures(const ReportInput& input);
/// Standard deviations of key frames relative to the first one along the path, the largest of these
/// and of neighbours, how many are not tied to the first or doubtful, and the longest part of the
/// path without a loop or GNSS.
json::Json uncertainty_figures(const ReportInput& input, const back_end::BackEnd& back_end,
                               const std::vector<back_end::KeyFrameDeviation>& deviations);
/// The same for each key frame, as a CSV file has it.
std::string key_frame_table(const ReportInput& input,
                            const std::vector<back_end::KeyFrameDeviation>& deviations);
/// Stretches of the map that are doubtful, with the key frames around them; see drive_doubt().
json::Json doubt_figures(const ReportInput& input, const back_end::BackEnd& back_end);
/// APE, RPE and KITTI's errors; null without truth. Throws InputError where the truth has none of
/// the session's time.
json::Json truth_figures(const ReportInput& input);

json::Json to_json(const map_quality::LocalThickness& thickness, bool has_ratio);
json::Json to_json(const map_quality::PassMisalignment& ghost);
json::Json to_json(const map_quality::MapEntropy& entropy);

/// A line per figure: name, value in words, whether it is good, what it means, and what is good.
json::Json verdicts(const json::Json& report);

/// One sentence on the whole: what a person has to look at.
std::string overall_verdict(const json::Json& report);

}  // namespace lidar_mapping::report
